"""The empty Cornell box: the walls of the full one, and a ceiling without gap or overlap."""

from __future__ import annotations

import numpy as np

from scenes.library import case
from scenes.library.cornell_box import empty_box


def test_the_walls_are_those_of_the_full_box() -> None:
    full, empty = case("cornell-box").scene, empty_box()
    known = {s.name: s for s in full.surfaces}
    assert empty.sensor == full.sensor
    for s in empty.surfaces:
        if not s.name.startswith("ceiling") and s.name != "lamp":
            assert s == known[s.name]
    assert empty.surfaces[0].emission == known["lamp"].emission
    assert empty.surfaces[0].shape.area == known["lamp"].shape.area


def test_the_ceiling_is_tiled() -> None:
    """Each random point of the ceiling lies in exactly one of its parts, all of which face down."""
    parts = [s for s in empty_box().surfaces if s.name.startswith(("lamp", "ceiling"))]
    x = np.random.default_rng(0).uniform(-1, 1, (1000, 2))
    inside = np.zeros((len(parts), 1000), dtype=bool)
    for k, part in enumerate(parts):
        low = np.array(part.shape.corner)
        high = low + part.shape.edge_u + part.shape.edge_v
        inside[k] = ((low[[0, 2]] < x) & (x < high[[0, 2]])).all(axis=1)
        assert low[1] == high[1] == 1
        np.testing.assert_array_equal(part.shape.normal, [0, -1, 0])
    assert (inside.sum(axis=0) == 1).all()
    assert np.isclose(sum(part.shape.area for part in parts), 4)
