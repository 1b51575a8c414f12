"""Truth by finite elements: every bounce of a diffuse scene of quads, without noise."""

from __future__ import annotations

import os
from importlib.metadata import version
from pathlib import Path

import numpy as np

from reference_tracer.finite_elements import solve
from scenes import Computed, Scene
from scenes.formats import exr

SINGLE = 2.0**-24
"""Relative error of a number that is written as a 32-bit float."""


def compute(scene: Scene, bounces: int, answer: Computed, path: Path, header: dict[str, str]) -> None:
    """Solve the scene, find the error by refinement, and write the images to a file.

    Args:
        scene, bounces: what to solve.
        answer: its mesh.
        path: the file.
        header: further texts for it.
    """
    solution = solve(scene, bounces, order=answer.order, levels=answer.levels, splits=answer.splits)
    off = solution.error.image.max(axis=1)
    error = np.where(off > 0, off + SINGLE, 0.0)
    source = (
        f"finite elements of lightproof {version('lightproof')}, legendre of order {solution.order} with "
        f"{solution.levels} levels, {solution.F.size} nodes; relative error of a pixel at most {error.max():.1g}"
    )
    partial = path.with_suffix(f".{os.getpid()}.exr")  # a run that is cut short leaves no half a truth behind
    texts = {"lightproof:source": source, "lightproof:error": " ".join(f"{e:.2g}" for e in error)}
    exr.write_bounces(partial, solution.image(), attributes=texts | header)
    partial.replace(path)
