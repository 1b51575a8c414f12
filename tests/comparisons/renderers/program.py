"""A renderer of another kind, as a program: it reads a scene as JSON, and draws E and TE of quads, pixel by pixel.

Its lamp is known in closed form, and the bounces it writes are what the tests ask for. It shares no code with ours,
and knows nothing of it but the JSON. ``--wrong`` makes it misbehave in one way.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import OpenImageIO as oiio


def centers(sensor: dict) -> tuple[np.ndarray, np.ndarray]:
    """Origin and directions of the rays through the centres of pixels, (height, width, 3)."""
    origin, target, up = (np.array(sensor[key], dtype=float) for key in ("origin", "target", "up"))
    forward = (target - origin) / np.linalg.norm(target - origin)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    above = np.cross(right, forward)
    width, height = sensor["width"], sensor["height"]
    half = np.tan(np.radians(sensor["fov"]) / 2) / min(width, height)
    x = (2 * np.arange(width) + 1 - width) * half
    y = (height - 1 - 2 * np.arange(height)) * half  # row 0 is the top
    return origin, forward + x[None, :, None] * right + y[:, None, None] * above


def emitted(scene: dict) -> np.ndarray:
    """E at the centre of each pixel, (height, width, channels); black on backs and beside the quads."""
    origin, d = centers(scene["sensor"])
    nearest = np.full(d.shape[:2], np.inf)
    image = None
    for surface in scene["surfaces"]:
        shape, emission = surface["shape"], surface.get("emission")
        corner, u, v = (np.array(shape[key], dtype=float) for key in ("corner", "edge_u", "edge_v"))
        n = np.cross(u, v)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (corner - origin) @ n / (d @ n)
        p = origin + t[..., None] * d - corner
        a = np.cross(p, v) @ n / (n @ n)
        b = np.cross(u, p) @ n / (n @ n)
        hit = (t > 0) & (t < nearest) & (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1)
        nearest[hit] = t[hit]
        radiance = np.array(emission["radiance"]) if emission else None
        if image is None:
            channels = 3 if radiance is None else len(radiance)
            image = np.zeros((*d.shape[:2], channels))
        image[hit] = 0.0
        if radiance is not None:
            image[hit & (d @ n < 0)] = radiance
    return image


def sums(scene: dict, bounces: int, spp: int, seed: int, shared: bool) -> np.ndarray:
    """S_0 … S_n with noise: bounce k is E / 2ᵏ, so that each is told from the others."""
    first = emitted(scene)
    terms = []
    for k in range(bounces + 1):
        stream = np.random.default_rng([seed, k] if shared else [seed, k, bounces])
        noise = stream.normal(size=first.shape) / np.sqrt(spp)
        terms.append(first * 0.5**k * (1 + 0.05 * noise * (k > 0)))
    return np.cumsum(terms, axis=0)


def write(path: Path, names: list[str], pixels: np.ndarray, kind: str = "float") -> None:
    height, width, _ = pixels.shape
    spec = oiio.ImageSpec(width, height, len(names), kind)
    spec.channelnames = names
    out = oiio.ImageOutput.create(str(path))
    assert out is not None, oiio.geterror()
    assert out.open(str(path), spec), out.geterror()
    assert out.write_image(np.ascontiguousarray(pixels, dtype=np.float32)), out.geterror()
    out.close()


def write_parts(path: Path, images: list[np.ndarray], names: list[str]) -> None:
    specs = []
    for k, image in enumerate(images):
        spec = oiio.ImageSpec(image.shape[1], image.shape[0], len(names), "float")
        spec.channelnames = names
        spec.attribute("oiio:subimagename", f"bounce{k}")
        specs.append(spec)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), specs)
    for k, image in enumerate(images):
        if k:
            assert out.open(str(path), specs[k], "AppendSubimage")
        assert out.write_image(np.ascontiguousarray(image, dtype=np.float32)), out.geterror()
    out.close()


def end_by(number: int) -> None:
    os.kill(os.getpid(), number)


def have_children() -> None:
    """One in the same process group, one that leaves it."""
    subprocess.Popen(["sleep", "3601"])
    subprocess.Popen(["setsid", "sleep", "3602"])


def hang_with_children() -> None:
    have_children()
    time.sleep(3600)


def devour() -> None:
    kept = []
    while True:
        kept.append(np.ones(1 << 22))
        time.sleep(0.02)


def chatter() -> None:
    while True:
        os.write(1, b"garbage " * 10_000)


def say(text: str, status: int) -> None:
    print(text, file=sys.stderr)
    sys.exit(status)


WRONG = {
    "crash": lambda output: end_by(signal.SIGSEGV),
    "abort": lambda output: os.abort(),
    "leave": lambda output: say("no more memory for textures", 3),
    "refuse": lambda output: say("unsupported: spheres of glass", 3),
    "hang": lambda output: time.sleep(3600),
    "hang-with-children": lambda output: hang_with_children(),
    "leave-children": lambda output: have_children(),
    "devour": lambda output: devour(),
    "chatter": lambda output: chatter(),
    "forget": lambda output: say("all is well", 0),
    "garbage": lambda output: [output.write_bytes(b"this is no image"), sys.exit(0)],
}
"""What ends the program early, or never."""


def main() -> None:
    options = argparse.ArgumentParser()
    options.add_argument("scene", type=Path)
    options.add_argument("--spp", type=int, default=1)
    options.add_argument("--seed", type=int, default=int(os.environ.get("PROGRAM_SEED", "0")))
    options.add_argument("--bounces", type=int, default=None)
    options.add_argument("-o", "--output", type=Path, required=True)
    options.add_argument("--layers", choices=["layers", "parts"])
    options.add_argument("--shared", action="store_true")
    options.add_argument("--kind", default="float")
    options.add_argument("--wrong", default="")
    options.add_argument("--calls", type=Path)
    asked = options.parse_args()
    if asked.calls:
        with asked.calls.open("a") as log:
            log.write(json.dumps([asked.bounces, asked.spp, asked.seed, os.getcwd(), os.getppid()]) + "\n")
    if asked.wrong:
        print(f"about to {asked.wrong}", flush=True)
    WRONG.get(asked.wrong, lambda output: None)(asked.output)

    scene = json.loads(asked.scene.read_text())
    dark = all(not any(s["material"]["albedo"]) for s in scene["surfaces"])
    bounces = 30 if asked.bounces is None else asked.bounces
    found = sums(scene, 0 if dark else bounces, asked.spp, asked.seed, asked.shared)
    names = {1: ["Y"], 3: ["R", "G", "B"]}[found.shape[-1]]
    if asked.wrong == "nan":
        found[-1, 2, 1] = np.nan
    if asked.wrong == "size":
        found = found[:, 1:]
    if asked.wrong == "grey":
        found, names = found[..., :1], ["Y"]
    terms = np.diff(found, axis=0, prepend=0.0)
    if asked.layers == "layers":
        channels = [f"bounce{k}.{name}" for k in range(len(terms)) for name in names]
        write(asked.output, channels, np.concatenate(list(terms), axis=-1))
    elif asked.layers == "parts":
        write_parts(asked.output, list(terms), names)
    else:
        write(asked.output, names, found[-1], asked.kind)
    if asked.wrong == "truncate":
        content = asked.output.read_bytes()
        asked.output.write_bytes(content[:-20])


if __name__ == "__main__":
    main()
