# /// script
# requires-python = ">=3.9"
# dependencies = ["numpy<2"]
# ///
"""A path tracer for diffuse quads, as a worker file: a process that Lightproof talks to.

It imports nothing of Lightproof, and needs another NumPy: its packages are its own. ``uv run --script quads.py``
makes an environment of what stands above, and runs it; docs/workers.md explains the protocol.

Rays start in a square of each pixel and are scattered by cosine, so that T is an average:

    TᵏE(x, v) = ρ · mean of Tᵏ⁻¹E(r(x, l), −l)        l distributed as cos θ / π
"""

import json
import os
import sys

import numpy as np

VERSION = "1.0"


class Unsupported(Exception):
    """The scene has a feature that this renderer lacks."""


# ---- the scene


def arrays(scene):
    """Corners, edges, normals (n, 3), albedo and radiance (n, channels) of all quads, and the sensor."""
    for surface in scene["surfaces"]:
        for part, kind in (("shape", "quad"), ("material", "lambertian")):
            if surface[part]["type"] != kind:
                raise Unsupported(f"{part} {surface[part]['type']}")
        if isinstance(surface["material"]["albedo"], dict):
            raise Unsupported("texture")
        if surface.get("two_sided"):
            raise Unsupported("two-sided surface")
        if surface.get("emission", {}).get("angular_profile"):
            raise Unsupported("angular profile")
    for light in scene.get("lights", ()):
        raise Unsupported(f"{light['type']} light")
    if scene["sensor"]["type"] != "pinhole":
        raise Unsupported(f"{scene['sensor']['type']} sensor")
    albedo = np.array([surface["material"]["albedo"] for surface in scene["surfaces"]])
    dark = [0.0] * albedo.shape[1]
    radiance = np.array([s.get("emission", {}).get("radiance", dark) for s in scene["surfaces"]])
    corner, u, v = (
        np.array([surface["shape"][key] for surface in scene["surfaces"]])
        for key in ("corner", "edge_u", "edge_v")
    )
    return (corner, u, v), albedo, radiance, scene["sensor"]


def camera_rays(sensor, rng):
    """Origins and directions (pixels, 3), each through a random place of its pixel, row 0 at the top."""
    origin, target, up = (np.array(sensor[key], dtype=float) for key in ("origin", "target", "up"))
    forward = (target - origin) / np.linalg.norm(target - origin)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    above = np.cross(right, forward)
    width, height = sensor["width"], sensor["height"]
    row, column = np.mgrid[:height, :width].reshape(2, -1) + rng.random((2, height * width))
    half = np.tan(np.radians(sensor["fov"]) / 2) / min(width, height)  # the view of the smaller axis
    x, y = (2 * column - width) * half, (height - 2 * row) * half
    d = forward + x[:, None] * right + y[:, None] * above
    return np.broadcast_to(origin, d.shape), d / np.linalg.norm(d, axis=1, keepdims=True)


# ---- light transport


def cast(quads, origin, d):
    """r(x, l): the points that rays meet first, the quads there (−1: none), and whether from the front."""
    corner, u, v = quads
    n = np.cross(u, v)
    square = np.sum(n * n, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (np.sum(corner * n, axis=1) - origin @ n.T) / (d @ n.T)
    p = origin[:, None] + t[..., None] * d[:, None] - corner
    a = np.sum(np.cross(p, v) * n, axis=2) / square
    b = np.sum(np.cross(u, p) * n, axis=2) / square
    inside = (t > 1e-9) & (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1)
    t = np.where(inside, t, np.inf)
    nearest = np.argmin(t, axis=1)
    lanes = np.arange(len(d))
    met = np.isfinite(t[lanes, nearest])
    point = origin + np.where(met, t[lanes, nearest], 0.0)[:, None] * d
    front = met & (np.sum(d * n[nearest], axis=1) < 0)
    return point, np.where(met, nearest, -1), front


def cosine_directions(quads, index, rng):
    """Directions about the normals of these quads, distributed as cos θ / π."""
    _, u, v = (edge[index] for edge in quads)
    n = np.cross(u, v)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    x = u / np.linalg.norm(u, axis=1, keepdims=True)
    y = np.cross(n, x)
    square, turn = rng.random((2, len(n)))
    r, phi = np.sqrt(square), 2 * np.pi * turn
    z = np.sqrt(1 - square)
    return (r * np.cos(phi))[:, None] * x + (r * np.sin(phi))[:, None] * y + z[:, None] * n


def render(scene, bounces, spp, seed):
    """TᵏE for each bounce k asked for, (len(bounces), height, width, channels)."""
    quads, albedo, radiance, sensor = arrays(scene)
    width, height, channels = sensor["width"], sensor["height"], albedo.shape[1]
    rng = np.random.default_rng(seed)
    last = max(bounces)
    images = np.zeros((last + 1, height * width, channels))
    for _ in range(spp):
        origin, d = camera_rays(sensor, rng)
        throughput = np.ones((height * width, channels))
        for k in range(last + 1):
            origin, index, front = cast(quads, origin, d)
            throughput = throughput * front[:, None]  # backs are black, and so is what lies beyond the scene
            images[k] += throughput * radiance[index]
            throughput = throughput * albedo[index]
            d = cosine_directions(quads, index, rng)
    return (images / spp).reshape(-1, height, width, channels)[list(bounces)]


# ---- the protocol


def main():
    """A line of JSON per request, and one with its scene; a line of JSON per reply, and the numbers of an image."""
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what is printed goes to the log, and can't be taken for a reply

    def reply(image=None, **message):
        replies.write(json.dumps(message).encode() + b"\n")
        if image is not None:
            replies.write(np.ascontiguousarray(image, dtype="<f8").tobytes())
        replies.flush()

    reply(type="ready", version=VERSION)
    print(f"NumPy {np.__version__}", file=sys.stderr)
    for line in sys.stdin.buffer:
        request, scene = json.loads(line), json.loads(sys.stdin.buffer.readline())
        if request["type"] != "render":
            reply(type="refused", feature=f"a request of the type {request['type']}")
            continue
        try:
            image = render(scene, request["bounces"], request["spp"], request["seed"])
        except Unsupported as missing:
            reply(type="refused", feature=str(missing))
        except Exception as error:
            reply(type="failed", message=f"{type(error).__name__}: {error}")
        else:
            reply(image, type="rendered", shape=image.shape)


if __name__ == "__main__":
    main()
