"""Images: rows from the top, any number of channels, whatever they were made of."""

from __future__ import annotations

import numpy as np
import pytest

from scenes import Image, SceneError


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.uint8, np.int64])
def test_an_array_comes_back_as_it_was(dtype: type) -> None:
    values = np.arange(24, dtype=dtype).reshape(2, 3, 4)
    image = Image(values)
    np.testing.assert_array_equal(image.array, values)
    assert image.array.dtype == np.float64
    assert image.channels == 4
    assert image == Image(values.tolist())
    assert hash(image) == hash(Image(values.tolist()))


def test_what_was_made_of_an_array_does_not_change_with_it() -> None:
    values = np.ones((1, 1, 1))
    image = Image(values)
    values[:] = 2
    image.array[:] = 3
    assert image.pixels == (((1.0,),),)


@pytest.mark.parametrize("shape", [(0, 1, 1), (1, 0, 1), (1, 1, 0), (2, 2), (1, 1, 1, 1), ()])
def test_other_shapes(shape: tuple[int, ...]) -> None:
    with pytest.raises(SceneError, match=r"Image\.pixels"):
        Image(np.ones(shape))


def test_the_first_wrong_number_is_named() -> None:
    values = np.ones((3, 4, 2))
    values[1, 2, 0], values[2, 3, 1] = np.nan, -1
    with pytest.raises(
        SceneError, match=r"Image\.pixels\[1\]\[2\]\[0\] = .*nan.*: expected a finite number ≥ 0"
    ):
        Image(values)
