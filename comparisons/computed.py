"""Truth by finite elements: every bounce of a diffuse scene of quads, without noise."""

from __future__ import annotations

import os
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from reference_tracer.finite_elements import solve
from scenes import Computed, Scene
from scenes.formats import exr


def compute(scene: Scene, bounces: int, answer: Computed, path: Path, header: dict[str, str]) -> None:
    """Solve the scene on two meshes and write the finer one's images to a file, with what the coarser one is off by.

    Args:
        scene, bounces: what to solve.
        answer: the coarser mesh.
        path: the file.
        header: further texts for it.
    """
    coarse = solve(scene, bounces, order=answer.order, levels=answer.levels, splits=answer.splits)
    fine = coarse.refined()
    images = fine.image().astype(np.float32).astype(np.float64)  # what the file holds
    source = (
        f"finite elements of lightproof {version('lightproof')}, legendre of order {fine.order} with {fine.levels} "
        f"levels, {fine.F.size} nodes; the error is that of order {coarse.order} with {coarse.levels} levels"
    )
    error = " ".join(f"{e:.2g}" for e in relative_error(coarse.image(), images))
    partial = path.with_suffix(f".{os.getpid()}.exr")  # a run that is cut short leaves no half a truth behind
    texts = {"lightproof:source": source, "lightproof:error": error}
    exr.write_bounces(partial, images, attributes=texts | header)
    partial.replace(path)


def relative_error(images: NDArray[np.float64], expected: NDArray[np.float64]) -> NDArray[np.float64]:
    """Root mean square of a pixel's error over the mean of the image, per bounce, of the worst channel.

    Where a bounce has no light it is the mean of the brightest bounce that the error is relative to.
    """
    off, mean = np.sqrt(((images - expected) ** 2).mean(axis=(1, 2))), expected.mean(axis=(1, 2))
    found: NDArray[np.float64] = (off / np.where(mean > 0, mean, mean.max(axis=0))).max(axis=1)
    return found
