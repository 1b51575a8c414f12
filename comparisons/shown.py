"""What a comparison shows beside its verdicts: images, and what image metrics say of them. None of it decides."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.metrics import partial_sum_metrics, term_metrics
from comparisons.results import Images
from scenes import Case
from scenes.formats import exr

Array = NDArray[np.float64]


def write_truth(folder: Path | None, case: Case, mean: Array, stderr: Array, name: str = "truth") -> None:
    """Write the truth of a case, once for all renderers; without a folder, nothing.

    Args:
        folder: of the run; it goes to its ``images/CASE``.
        case: whose truth it is.
        mean, stderr: ``(bounces, height, width, channels)``, radiance.
        name: of the file.

    Raises:
        ImageError, OSError: it can't be written.
    """
    if folder is not None:
        path = folder / _path(case, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        exr.write_bounces(path, mean, stderr, wavelengths=case.wavelengths)


def shown(
    folder: Path | None,
    case: Case,
    renderer: str,
    made: str,
    mean: Array,
    stderr: Array,
    truth: Array,
    truth_name: str = "truth",
) -> dict[str, Any]:
    """The fields ``images``, ``metrics`` and ``term_metrics`` of a comparison; without a folder, none of them.

    Args:
        folder: of the run; images go to its ``images/CASE``.
        case, renderer: what was compared.
        made: how the image was made, for its header.
        mean, stderr, truth: ``(bounces, height, width, channels)``, radiance.
        truth_name: of the file with the truth, as given to ``write_truth``.

    Raises:
        ImageError, OSError: the image can't be written.
    """
    if folder is None:
        return {}
    images = Images(
        truth=_path(case, truth_name).as_posix(),
        renderer=_path(case, renderer.replace(":", "-")).as_posix(),
    )
    exr.write_bounces(folder / images.renderer, mean, stderr, {"lightproof:source": made}, case.wavelengths)
    metrics, of_terms = partial_sum_metrics(mean, truth), term_metrics(mean, truth)
    return {"images": images, "metrics": metrics, "term_metrics": of_terms}


def _path(case: Case, name: str) -> Path:
    return Path("images", case.name, f"{name}.exr")
