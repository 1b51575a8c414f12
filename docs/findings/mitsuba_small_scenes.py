"""A minimal scene that shows the finding beside this file, and its cause. Needs Mitsuba 3 only; takes two minutes."""

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)
T = mi.ScalarTransform4f


def furnace(size: float) -> mi.Scene:
    """A cube of half edge ``size``, walls inwards, albedo ½, emission 1, seen from a point off its centre."""
    view = T().look_at(
        origin=[0.3 * size, -0.2 * size, 0.7 * size], target=[-0.2 * size, 0.1 * size, -size], up=[0, 1, 0]
    )
    film = {"type": "hdrfilm", "width": 64, "height": 64, "rfilter": {"type": "box"}}
    turns = [
        T(),
        T().rotate([1, 0, 0], 180),
        *(T().rotate(a, d) for a in ([1, 0, 0], [0, 1, 0]) for d in (90, -90)),
    ]
    walls = {
        f"wall{i}": {
            "type": "rectangle",
            "to_world": T().scale(size) @ turn @ T().translate([0, 0, -1]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}},
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
        }
        for i, turn in enumerate(turns)
    }
    camera = {"type": "perspective", "fov": 90, "near_clip": 1e-6 * size, "to_world": view, "film": film}
    # optimised, the lamps come in the order of their addresses, and the same seed gives another image each time
    return mi.load_dict(
        {"type": "scene", "sensor": camera | {"sampler": {"type": "independent"}}, **walls}, optimize=False
    )


print("direct light, 0.5 everywhere by the white furnace test, whatever the size")
print("size    emitter samples      BSDF samples         both")
for size in (100.0, 1.0, 1e-2, 1e-3, 1e-4):
    scene, cells = furnace(size), []
    for emitter_samples, bsdf_samples in ((1, 0), (0, 1), (1, 1)):
        direct = {"emitter_samples": emitter_samples, "bsdf_samples": bsdf_samples, "hide_emitters": False}
        integrator = mi.load_dict({"type": "direct"} | direct)
        means = [
            np.array(mi.render(scene, integrator=integrator, spp=64, seed=s)).mean() - 1 for s in range(1, 17)
        ]
        cells.append(f"{np.mean(means):.5f} ± {np.std(means, ddof=1) / 4:.5f}")
    print(f"{size:<7g} " + "   ".join(cells))


# ---- the cause: the same estimate in NumPy, rays moved off the wall as Mitsuba moves them


def hit(o: np.ndarray, d: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Where rays from inside meet the cube, and its normal there, inwards; all ``(3, n)``."""
    with np.errstate(divide="ignore"):
        t = np.where(d != 0, (np.sign(d) * size - o) / d, np.inf)
    wall, each = t.argmin(axis=0), np.arange(d.shape[1])
    p, n = o + t.min(axis=0) * d, np.zeros_like(o)
    n[wall, each] = -np.sign(d[wall, each])
    p[wall, each] = -size * n[wall, each]
    return p, n


def towards(p: np.ndarray, q: np.ndarray, n: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray]:
    """The direction from p to a point q of the walls, and the density of emitter samples there."""
    d = (q - p) / (dist := np.linalg.norm(q - p, axis=0))
    cos = np.maximum(-(d * n).sum(axis=0), 0)
    return d, np.divide(dist**2, cos * 24 * size**2, out=np.zeros_like(cos), where=cos > 0)


def seen(size: float, rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the camera is, points that it sees, and the normals there."""
    eye, target = size * np.array([0.3, -0.2, 0.7]), size * np.array([-0.2, 0.1, -1.0])
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    x, y = rng.uniform(-1, 1, (2, count, 1))
    view = (forward + x * right + y * np.cross(right, forward)).T
    return eye[:, None], *hit(np.tile(eye[:, None], count), view, size)


def offset(p: np.ndarray) -> np.ndarray:
    """How far off the surface Mitsuba's rays start."""
    return 1500 * 2.0**-24 * (1 + np.abs(p).max(axis=0))


def estimate(size: float, moved: bool, count: int = 2_000_000) -> tuple[float, float]:
    """The mean of direct light by both strategies, weighted by the power heuristic, and its standard error."""
    rng, each = np.random.default_rng(1), np.arange(count)
    _, p, n = seen(size, rng, count)

    lit, normals = rng.uniform(-size, size, (3, count)), np.zeros((3, count))
    wall, side = rng.integers(0, 3, count), rng.choice([-1.0, 1.0], count)
    lit[wall, each], normals[wall, each] = side * size, -side
    d, by_emitter = towards(p, lit, normals, size)
    by_bsdf = np.maximum((d * n).sum(axis=0), 0) / np.pi
    # 0.5 · by_bsdf / by_emitter, times by_emitter² / (by_emitter² + by_bsdf²)
    found = 0.5 * by_bsdf * by_emitter / np.maximum(by_emitter**2 + by_bsdf**2, 1e-300)

    r, phi = np.sqrt(rng.random(count)), 2 * np.pi * rng.random(count)
    d, normal = np.empty((3, count)), np.abs(n).argmax(axis=0)
    d[(normal + 1) % 3, each], d[(normal + 2) % 3, each] = r * np.cos(phi), r * np.sin(phi)
    d[normal, each] = n[normal, each] * (cos := np.sqrt(1 - r**2))
    q, at_q = hit(p + (offset(p) if moved else 0.0) * n, d, size)
    by_bsdf, by_emitter = cos / np.pi, towards(p, q, at_q, size)[1]
    found += 0.5 * by_bsdf**2 / (by_bsdf**2 + by_emitter**2)
    return float(found.mean()), float(found.std() / np.sqrt(count))


print("\nby NumPy, both strategies weighted: rays from where the surface is, and from where Mitsuba's start")
for size in (100.0, 1.0, 1e-2, 1e-3, 1e-4):
    cells = [estimate(size, moved) for moved in (False, True)]
    print(f"{size:<7g} " + "   ".join(f"{mean:.5f} ± {error:.5f}" for mean, error in cells))


def foreshortened(size: float, count: int = 2_000_000) -> float:
    """How much smaller cos θ towards the camera is from where a ray starts than from the surface, on average."""
    eye, p, n = seen(size, np.random.default_rng(1), count)
    of_point, of_ray = (
        (n * v).sum(axis=0) / np.linalg.norm(v, axis=0) for v in (eye - p, eye - p - offset(p) * n)
    )
    return float((np.maximum(of_ray, 0) / of_point).mean())


print("\nE by particles, 1 everywhere: ptracer, and cos θ from where a ray starts by that from the surface")
particles = mi.load_dict({"type": "ptracer", "max_depth": 1, "hide_emitters": False})
for size in (1.0, 1e-2, 1e-3, 3e-4):
    means = [
        np.array(mi.render(furnace(size), integrator=particles, spp=64, seed=s)).mean() for s in range(1, 17)
    ]
    error = np.std(means, ddof=1) / 4
    print(f"{size:<7g} {np.mean(means):.4f} ± {error:.4f}   {foreshortened(size):.4f}")
