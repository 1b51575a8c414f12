"""A minimal program that shows the finding beside this file. Needs Mitsuba 3, for the last table LLVM; minutes."""

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)
DIMENSIONS = 40


def numbers(kind: str, count: int, pixels: int) -> np.ndarray:
    """What the samples of a pixel are given, for many pixels: ``(pixels · count, dimensions)``."""
    sampler, rows = mi.load_dict({"type": kind, "sample_count": count}), []
    for pixel in range(pixels):
        sampler.seed(pixel)
        for _ in range(sampler.sample_count()):
            rows.append([sampler.next_1d() for _ in range(DIMENSIONS)])
            sampler.advance()
    return np.array(rows)


print(
    "correlation of two numbers of one sample, by how many dimensions they are apart; 0 if they are independent"
)
for kind in ("independent", "stratified", "multijitter", "orthogonal", "ldsampler"):
    for count in (4, 16, 64, 256):
        x = np.sqrt(12) * (numbers(kind, count, max(64, 16384 // count)) - 0.5)
        correlation = x.T @ x / len(x)
        lags = [np.diagonal(correlation, lag).mean() for lag in range(DIMENSIONS)]
        largest = sorted(range(1, DIMENSIONS - 4), key=lambda lag: -abs(lags[lag]))[:3]
        shown = ", ".join(f"{lags[lag]:+.2f} at {lag}" for lag in largest)
        print(f"{kind:12} {count:4} samples: {shown}   (noise {1 / np.sqrt(len(x)):.3f})")


def terms(kind: str, count: int, renders: int) -> tuple[np.ndarray, np.ndarray]:
    """Means of bounces 0 to 5 over the image of the Cornell box that Mitsuba comes with, with standard errors.

    Compiled, each sample has a stream of its own: images of two depths share their paths, if they share their seed.
    """
    scene = mi.cornell_box()
    scene["sensor"]["film"] = {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}}
    scene["sensor"]["sampler"] = {"type": kind, "sample_count": count}
    loaded = mi.load_dict(scene)
    depths = [mi.load_dict({"type": "path", "max_depth": d, "rr_depth": 1 << 20}) for d in range(1, 7)]
    sums = [
        [np.array(mi.render(loaded, integrator=path, spp=count, seed=1000 + i)).mean() for path in depths]
        for i in range(renders)
    ]
    found = np.diff(sums, axis=1, prepend=0)
    return found.mean(axis=0), found.std(axis=0, ddof=1) / np.sqrt(renders)


def furnace(kind: str, count: int, albedo: float) -> mi.Scene:
    """A closed box that emits 1 and reflects everywhere: 1 / (1 - albedo) in every pixel; all else as by default."""
    white = {"type": "rgb", "value": albedo}
    box = {
        "type": "cube",
        "flip_normals": True,
        "bsdf": {"type": "diffuse", "reflectance": white},
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
    }
    film = {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}}
    sensor = {"type": "perspective", "film": film, "sampler": {"type": kind, "sample_count": count}}
    return mi.load_dict({"type": "scene", "integrator": {"type": "path"}, "box": box, "sensor": sensor})


print("closed box, Russian roulette as by default: deviation of the whole image")
for kind, count in (
    ("independent", 16),
    ("orthogonal", 25),
    ("multijitter", 16),
    ("ldsampler", 16),
    ("ldsampler", 64),
    ("stratified", 16),
    ("stratified", 64),
):
    row = []
    for albedo in (0.5, 0.8, 0.9):  # at 0.95 ldsampler does not come back
        scene = furnace(kind, count, albedo)
        means = [np.array(mi.render(scene, spp=count, seed=i)).mean() for i in range(640 // count)]
        error = np.std(means, ddof=1) / np.sqrt(len(means))
        row.append(f"{100 * ((1 - albedo) * np.mean(means) - 1):+.1f} ± {100 * (1 - albedo) * error:.1f} %")
    print(f"{kind:12} {count:4} samples: {'  '.join(row)}")


def floor(kind: str, count: int) -> mi.Scene:
    """A grey floor under four grey point lights of 1, 4, 2 and 8: direct light, in a spectral variant."""
    places = [(-1, -1, 1.0), (1, -1, 4.0), (-1, 1, 2.0), (1, 1, 8.0)]
    lamps = {
        f"lamp{i}": {
            "type": "point",
            "position": [x, 1, z],
            "intensity": {"type": "spectrum", "value": value},
        }
        for i, (x, z, value) in enumerate(places)
    }
    turn = mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale(3)
    grey = {"type": "diffuse", "reflectance": {"type": "spectrum", "value": 0.5}}
    sensor = {
        "type": "perspective",
        "fov": 60,
        "to_world": mi.ScalarTransform4f().look_at([0, 4, 0], [0, 0, 0], [0, 0, 1]),
        "film": {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}},
        "sampler": {"type": kind, "sample_count": count},
    }
    ground = {"type": "rectangle", "to_world": turn, "bsdf": grey}
    path = {"type": "path", "max_depth": 2}
    return mi.load_dict({"type": "scene", "integrator": path, "ground": ground, "sensor": sensor, **lamps})


def of_channels(kind: str, count: int, renders: int) -> tuple[np.ndarray, np.ndarray]:
    """Means of R, G and B over the image of the floor, with standard errors."""
    scene = floor(kind, count)
    found = [np.array(mi.render(scene, spp=count, seed=i)).mean(axis=(0, 1)) for i in range(renders)]
    return np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / np.sqrt(renders)


mi.set_variant("scalar_spectral")
print("grey floor under grey lamps: deviation of R, G and B from what independent numbers give")
truth, its_error = of_channels("independent", 1024, 60)
for kind, count in (
    ("independent", 16),
    ("orthogonal", 25),
    ("multijitter", 16),
    ("ldsampler", 16),
    ("stratified", 16),
    ("stratified", 64),
):
    mean, error = of_channels(kind, count, 6400 // count)
    both = np.hypot(error, its_error) / truth
    row = "  ".join(
        f"{100 * (m / t - 1):+.2f} ± {100 * e:.2f} %" for m, t, e in zip(mean, truth, both, strict=True)
    )
    print(f"{kind:12} {count:4} samples: {row}")

mi.set_variant("llvm_ad_rgb")
print("Cornell box: deviation of bounces 0 to 5 from what independent numbers give")
truth, its_error = terms("independent", 1024, 60)
for kind, count, renders in (
    ("stratified", 4, 1200),
    ("stratified", 16, 500),
    ("ldsampler", 4, 1200),
    ("ldsampler", 16, 500),
):
    mean, error = terms(kind, count, renders)
    both = np.hypot(error, its_error) / truth
    row = "  ".join(
        f"{100 * (m / t - 1):+.1f} ± {100 * e:.1f} %" for m, t, e in zip(mean, truth, both, strict=True)
    )
    print(f"{kind} {count}: {row}")
