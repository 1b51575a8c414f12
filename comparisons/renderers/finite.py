"""Images with a value that is no number: whoever made one has failed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from comparisons.renderers.protocol import Images, RendererFailed


def check_finite(images: Images, did: str, names: Sequence[str] = ()) -> None:
    """Refuse NaN and infinite values.

    Args:
        images: ``(n, height, width, channels)``.
        did: what the renderer did with them, as a verb: returned, wrote.
        names: of the images, where there may be several.

    Raises:
        RendererFailed: saying how many pixels, and where the first one is.
    """
    wrong = ~np.isfinite(images).all(axis=-1)
    if wrong.any():
        i, y, x = np.argwhere(wrong)[0]
        where = f"{names[i]}, " if names else ""
        raise RendererFailed(
            f"{did} {wrong.sum()} of {wrong.size} pixels that are not finite (NaN or infinite), the first in "
            f"{where}row {y}, column {x}"
        )
