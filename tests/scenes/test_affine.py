"""Affine maps: what each constructor does, composition, similarities, and what is no map."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from scenes import Affine, SceneError

Z = (0.0, 0.0, 1.0)
TURN = Affine.rotation((1, 2, -3), 50)
SIMILARITIES = {
    "nothing": Affine(),
    "translation": Affine.translation((3, -1, 2)),
    "rotation": TURN,
    "scaling": Affine.scaling(2.5),
    "reflection": Affine.reflection((1, 2, 2)),
    "point reflection": Affine.scaling(-1),
    "all of them": Affine.translation((1, 2, 3)) @ TURN @ Affine.scaling(0.3) @ Affine.reflection((0, 1, 1)),
}
OTHERS = {
    "stretch": Affine.scaling((1, 2, 3)),
    "shear": Affine(((1, 0.4, 0.1), (0, 2, 0.3), (0.2, 0, 1)), (1, 2, 3)),
    "stretch and mirror": Affine.scaling((1, -2, 3)) @ TURN,
}
MAPS = SIMILARITIES | OTHERS
similarities = pytest.mark.parametrize("affine", SIMILARITIES.values(), ids=SIMILARITIES)
others = pytest.mark.parametrize("affine", OTHERS.values(), ids=OTHERS)
maps = pytest.mark.parametrize("affine", MAPS.values(), ids=MAPS)


def test_what_each_constructor_does() -> None:
    x = np.array([[1.0, 0.0, 3.0], [0.0, 2.0, 4.0], [0.0, 0.0, 5.0]])  # three points as columns
    np.testing.assert_allclose(Affine.translation((1, 2, 3)).points(x), np.add(x, [[1], [2], [3]]))
    np.testing.assert_allclose(Affine.translation((1, 2, 3)).vectors(x), x)
    np.testing.assert_allclose(Affine.rotation(Z, 90).points((1, 2, 3)), [-2, 1, 3], atol=1e-15)
    np.testing.assert_allclose(Affine.rotation((1, 1, 1), 120).points((1, 2, 3)), [3, 1, 2], atol=1e-15)
    np.testing.assert_allclose(Affine.scaling(2).points(x), 2 * x)
    np.testing.assert_allclose(Affine.scaling((1, 2, 3)).points((1, 1, 1)), [1, 2, 3])
    np.testing.assert_allclose(Affine.reflection((0, 0, 5)).points((1, 2, 3)), [1, 2, -3])
    np.testing.assert_allclose(Affine.reflection((1, -1, 0)).points((1, 2, 3)), [2, 1, 3], atol=1e-15)


@maps
def test_composition_and_inverse(affine: Affine) -> None:
    x = np.random.default_rng(2).normal(size=(3, 5))
    first, last = OTHERS["shear"], affine
    np.testing.assert_allclose((last @ first).points(x), last.points(first.points(x)), rtol=1e-13)
    np.testing.assert_allclose(affine.inverse.points(affine.points(x)), x, atol=1e-14)
    assert affine.mirrors == (np.linalg.det(affine.matrix) < 0)
    assert affine.inverse.mirrors == affine.mirrors


@similarities
def test_the_factor_of_a_similarity(affine: Affine) -> None:
    a, b = np.random.default_rng(3).normal(size=(2, 3))
    distance = np.linalg.norm(affine.points(a) - affine.points(b))
    assert distance == pytest.approx(affine.scale * np.linalg.norm(a - b))


@others
def test_no_similarity(affine: Affine) -> None:
    assert affine.scale is None


@pytest.mark.parametrize(
    ("make", "place"),
    [
        (lambda: Affine(((1, 0, 0), (0, 1, 0), (1, 1, 0))), "Affine.linear"),
        (lambda: Affine.scaling((1, 0, 1)), "Affine.linear"),
        (lambda: Affine.scaling(math.nan), "Affine.linear[0][0]"),
        (lambda: Affine.scaling((1, 2)), "Affine.factor"),
        (lambda: Affine.rotation((0, 0, 0), 30), "Affine.axis"),
        (lambda: Affine.rotation((0, 1), 30), "Affine.axis"),
        (lambda: Affine.reflection((0, 0, 0)), "Affine.normal"),
        (lambda: Affine.translation((0, 0, math.inf)), "Affine.offset[2]"),
        (lambda: Affine.translation((0, 0)), "Affine.offset"),
    ],
)
def test_what_is_no_map(make: Any, place: str) -> None:
    with pytest.raises(SceneError) as caught:
        make()
    assert caught.value.path == place
