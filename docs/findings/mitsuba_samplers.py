"""A minimal program that shows the finding beside this file. Needs Mitsuba 3, for the second table LLVM; minutes."""

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
