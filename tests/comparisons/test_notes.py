"""What is said of samples besides the verdict."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from comparisons.notes import notes
from comparisons.renderers import Entry


@pytest.mark.parametrize(("differences", "told"), [(False, [0, 1]), (True, [0])])
def test_differences_of_independent_images_may_be_negative(differences: bool, told: list[int]) -> None:
    """Their noise has both signs. Bounce 0 is an image itself."""
    lowest = np.ones((4, 4, 3))
    lowest[2, 1] = -0.5
    bounces: Any = [SimpleNamespace(bounce=k, denominator=1.0, known=None, dominance=0.1) for k in (0, 1)]
    sampler: Any = SimpleNamespace(pixels={k: SimpleNamespace(lowest=lowest) for k in (0, 1)})
    found = notes(bounces, sampler, Entry("", "", "", differences=differences))
    assert found == [
        f"Bounce {k}: radiance is negative in 1 pixels, down to -0.5 in row 2, column 1; expected none"
        for k in told
    ]
