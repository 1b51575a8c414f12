"""Each field by itself: values that it can't have, and names that no field has, from Python and from JSON."""

from __future__ import annotations

import math
import re
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any, NamedTuple

import msgspec
import pytest

from scenes import Scene, SceneError

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("good_scenes.py"))))
ALBEDO, BALL, BLEND, CHECKS = shared.ALBEDO, shared.BALL, shared.BLEND, shared.CHECKS
CONSTANT, DIRECTIONAL, DISK, ELLIPSOID = shared.CONSTANT, shared.DIRECTIONAL, shared.DISK, shared.ELLIPSOID
FROSTED, GLASS, GOOD, HARMONICS = shared.FROSTED, shared.GLASS, shared.GOOD, shared.HARMONICS
LAMP, MAP, MESH, METAL, METER = shared.LAMP, shared.MAP, shared.MESH, shared.METAL, shared.METER
MIRROR, POINT, QUAD, RICH, ROUGH = shared.MIRROR, shared.POINT, shared.QUAD, shared.RICH, shared.ROUGH
SPOT, TEXTURE, ZONE = shared.SPOT, shared.TEXTURE, shared.ZONE
document, refusal = shared.document, shared.refusal

NAN, INF = math.nan, math.inf


class Bad(NamedTuple):
    """A value that some field of the good scene can't have.

    Attributes:
        parent, field: where it stands.
        value: what is put there.
        index: the component that is wrong, where it is one; several for one in lists of lists.
        root: the good scene.
    """

    parent: str
    field: str
    value: Any
    index: int | tuple[int, ...] | None = None
    root: Scene = GOOD

    @property
    def indices(self) -> tuple[int, ...]:
        return () if self.index is None else self.index if isinstance(self.index, tuple) else (self.index,)

    @property
    def tail(self) -> str:
        return self.field + "".join(f"[{i}]" for i in self.indices)

    @property
    def found(self) -> Any:
        value = self.value
        for i in self.indices:
            value = value[i]
        return value


BAD = [
    Bad(QUAD, "edge_v", [2.0, 0.0, 0.0]),
    Bad(QUAD, "edge_v", [-1.0, 1e-10, 0.0]),
    Bad(QUAD, "edge_v", [0.0, 0.0, 0.0]),
    Bad(QUAD, "edge_v", [0.0, 1.0]),
    Bad(QUAD, "edge_u", [1.0, NAN, 0.0], 1),
    Bad(QUAD, "corner", [0.0, 0.0, -INF], 2),
    Bad(QUAD, "corner", ["0", 0.0, 0.0], 0),
    Bad(QUAD, "corner", "origin"),
    Bad(BALL, "center", [INF, 0.0, 0.0], 0),
    Bad(BALL, "radius", 0.0),
    Bad(BALL, "radius", -1.0),
    Bad(BALL, "radius", NAN),
    Bad(BALL, "radius", INF),
    Bad(BALL, "radius", "1"),
    Bad(BALL, "radius", None),
    Bad(BALL, "radius", True),
    Bad(BALL, "radius", 10**400),
    Bad(BALL, "inward", 1),
    Bad(ALBEDO, "albedo", [-0.1, 0.5, 0.5], 0),
    Bad(ALBEDO, "albedo", [0.5, 1.001, 0.5], 1),
    Bad(ALBEDO, "albedo", [0.5, 0.5, NAN], 2),
    Bad(ALBEDO, "albedo", [0.5, INF, 0.5], 1),
    Bad(ALBEDO, "albedo", [0.5, 10**400, 0.5], 1),
    Bad(ALBEDO, "albedo", [0.5, True, 0.5], 1),
    Bad(ALBEDO, "albedo", ["a", 0.5, 0.5], 0),
    Bad(ALBEDO, "albedo", []),
    Bad(ALBEDO, "albedo", 0.5),
    Bad(ALBEDO, "albedo", "grey"),
    Bad(LAMP, "radiance", [1.0, -1e-9, 1.0], 1),
    Bad(LAMP, "radiance", [1.0, 1.0, NAN], 2),
    Bad(LAMP, "radiance", [INF, 1.0, 1.0], 0),
    Bad(LAMP, "radiance", []),
    Bad(LAMP, "polar_range", 45.0),
    Bad(LAMP, "angular_profile", 1.0),
    Bad(LAMP, "angular_profile", []),
    Bad(LAMP, "angular_profile", [1.0, 0.5], 0),
    Bad(LAMP, "angular_profile", [[1.0, 1.0, 1.0]]),  # one cosine
    Bad(LAMP, "angular_profile", [[0.0, 0.0, 0.0]] * 2),
    Bad(LAMP, "angular_profile", [[1.0, 1.0], [1.0, 1.0]], 0),
    Bad(LAMP, "angular_profile", [[1.0, 1.0, 1.0], [1.0, 1.0]], 1),
    Bad(LAMP, "angular_profile", [[1.0, 1.0, 1.0], [1.0, -1e-9, 1.0]], (1, 1)),
    Bad(LAMP, "angular_profile", [[1.0, 1.0, NAN], [1.0, 1.0, 1.0]], (0, 2)),
    Bad(LAMP, "angular_profile", [[INF, 1.0, 1.0], [1.0, 1.0, 1.0]], (0, 0)),
    Bad(ZONE, "low", -1.0),
    Bad(ZONE, "low", NAN),
    Bad(ZONE, "low", "10"),
    Bad(ZONE, "high", 10.0),  # equal to low
    Bad(ZONE, "high", 5.0),  # below low
    Bad(ZONE, "high", 180.5),
    Bad(ZONE, "high", INF),
    Bad(ZONE, "axis", [0.0, 0.0, 0.0]),
    Bad(ZONE, "axis", [0.0, NAN, 1.0], 1),
    Bad("sensor", "origin", [0.0, INF, 0.0], 1),
    Bad("sensor", "target", [0.0, -4.0, 1.0]),  # the origin
    Bad("sensor", "up", [0.0, 2.0, 0.0]),  # parallel to the view
    Bad("sensor", "up", [0.0, -2.0, 1e-12]),  # as good as parallel
    Bad("sensor", "up", [0.0, 0.0, 0.0]),
    Bad("sensor", "fov", 0.0),
    Bad("sensor", "fov", 180.0),
    Bad("sensor", "fov", -30.0),
    Bad("sensor", "fov", NAN),
    Bad("sensor", "fov", "wide"),
    Bad("sensor", "width", 0),
    Bad("sensor", "height", -3),
    Bad("sensor", "width", 2.5),
    Bad("sensor", "height", "64"),
    Bad("sensor", "height", True),
    Bad("surfaces[0]", "name", ""),
    Bad("surfaces[0]", "name", 7),
    Bad("surfaces[0]", "shape", None),
    Bad("surfaces[0]", "material", "white"),
    Bad("surfaces[0]", "emission", 1.0),
    Bad("", "sensor", None),
    Bad("", "surfaces", None),
    Bad("", "lights", 3),
]


def bad(root: Scene, parent: str, field: str, value: Any, *index: int) -> Bad:
    return Bad(parent, field, value, index or None, root)


SQUARE = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]
BAD += [
    bad(RICH, DISK, "axis_v", [-2.0, 0.0, 0.0]),
    bad(RICH, DISK, "axis_u", [0.0, NAN, 0.0], 1),
    bad(RICH, DISK, "center", [0.0, 0.0]),
    bad(RICH, ELLIPSOID, "axis_w", [1.0, 1.0, 0.0]),  # in the plane of the others
    bad(RICH, ELLIPSOID, "axis_w", [0.0, 0.0, 0.0]),
    bad(RICH, ELLIPSOID, "axis_v", [0.0, INF, 0.0], 1),
    bad(RICH, ELLIPSOID, "center", "here"),
    bad(RICH, ELLIPSOID, "inward", None),
    bad(RICH, MESH, "vertices", 5),
    bad(RICH, MESH, "vertices", []),
    bad(RICH, MESH, "vertices", [*SQUARE[:3], [1.0, NAN, 0.0]], 3, 1),
    bad(RICH, MESH, "vertices", [*SQUARE[:3], [1.0, "0", 0.0]], 3, 1),
    bad(RICH, MESH, "vertices", [*SQUARE[:3], [1.0, True, 0.0]], 3, 1),
    bad(RICH, MESH, "vertices", [*SQUARE[:3], [1.0, 10**400, 0.0]], 3, 1),
    bad(RICH, MESH, "vertices", [*SQUARE[:3], [1.0, 0.0]], 3),
    bad(RICH, MESH, "vertices", [*SQUARE[:3], None], 3),
    bad(RICH, MESH, "triangles", "012"),
    bad(RICH, MESH, "triangles", []),
    bad(RICH, MESH, "triangles", [[0, 1, 2], [1, 4, 2]], 1, 1),
    bad(RICH, MESH, "triangles", [[0, 1, 2], [1, -1, 2]], 1, 1),
    bad(RICH, MESH, "triangles", [[0, 1, 2], [1, 2.5, 2]], 1, 1),
    bad(RICH, MESH, "triangles", [[0, 1, 2], [1, 10**400, 2]], 1, 1),
    bad(RICH, MESH, "triangles", [[0, 1, 2], [1, 2]], 1),
    bad(RICH, MESH, "normals", [[0.0, 0.0, 1.0]] * 3),
    bad(RICH, MESH, "normals", [[0.0, 0.0, 1.0]] * 3 + [[0.0, 0.0, 0.0]], 3),
    bad(RICH, MESH, "normals", [[0.0, 0.0, 1.0]] * 3 + [[0.1, 0.0, -1.0]], 3),  # at the back
    bad(RICH, MESH, "normals", [[0.0, 0.0, 1.0]] * 3 + [[0.1, 0.0, INF]], 3, 2),
    bad(RICH, MESH, "uv", [[0.0, 0.0]] * 5),
    bad(RICH, MESH, "uv", [[0.0, 0.0]] * 3 + [[0.0, NAN]], 3, 1),
    bad(RICH, MESH, "uv", [[0.0, 0.0]] * 3 + [[0.0, 0.0, 0.0]], 3),
    bad(RICH, f"{CHECKS}.albedo", "even", [0.5, 1.5, 0.5], 1),
    bad(RICH, f"{CHECKS}.albedo", "odd", [0.5, 0.5]),
    bad(RICH, f"{CHECKS}.albedo", "columns", 0),
    bad(RICH, f"{CHECKS}.albedo", "rows", 1.5),
    bad(RICH, f"{CHECKS}.albedo", "rows", True),
    bad(RICH, f"{TEXTURE}.albedo", "interpolation", "cubic"),
    bad(RICH, f"{TEXTURE}.albedo", "interpolation", ["nearest"]),
    bad(RICH, f"{TEXTURE}.albedo", "image", [[[0.5]]]),
    bad(RICH, f"{TEXTURE}.albedo.image", "pixels", []),
    bad(RICH, f"{TEXTURE}.albedo.image", "pixels", [[]], 0),
    bad(RICH, f"{TEXTURE}.albedo.image", "pixels", [[[]]], 0, 0),
    bad(RICH, f"{TEXTURE}.albedo.image", "pixels", [[[0.1]], [[0.1], [0.2]]], 1),
    bad(RICH, f"{TEXTURE}.albedo.image", "pixels", [[[0.1, 0.2], [0.1]]], 0, 1),
    bad(RICH, f"{TEXTURE}.albedo.image", "pixels", [[[0.1, -0.2]]], 0, 0, 1),
    bad(RICH, f"{TEXTURE}.albedo.image", "pixels", [[[0.1, INF]]], 0, 0, 1),
    bad(RICH, f"{TEXTURE}.albedo.image", "pixels", [[["0.1", 0.2]]], 0, 0, 0),
    bad(RICH, GLASS, "interior_ior", 0.0),
    bad(RICH, GLASS, "exterior_ior", NAN),
    bad(RICH, GLASS, "interior_ior", 1.0),  # that of the exterior
    bad(RICH, ROUGH, "shadowing", "smith"),
    bad(RICH, MIRROR, "reflectance", [0.5, 0.5, 1.1], 2),
    bad(RICH, MIRROR, "reflectance", 1.0),
    bad(RICH, METAL, "eta", [0.5, 0.0, 0.5], 1),
    bad(RICH, METAL, "eta", [0.5, -1.0, 0.5], 1),
    bad(RICH, METAL, "k", [0.5, -1.0, 0.5], 1),
    bad(RICH, METAL, "k", [0.5, 1.0]),
    bad(RICH, ROUGH, "alpha", 0.0),
    bad(RICH, ROUGH, "alpha", 1.01),
    bad(RICH, ROUGH, "k", [NAN, 1.0, 1.0], 0),
    bad(RICH, FROSTED, "alpha", "smooth"),
    bad(RICH, FROSTED, "interior_ior", 1.0),  # that of the exterior
    bad(RICH, FROSTED, "exterior_ior", -1.0),
    bad(RICH, BLEND, "weight", 1.5),
    bad(RICH, BLEND, "weight", NAN),
    bad(RICH, BLEND, "second", "grey"),
    bad(RICH, BLEND, "first", None),
    bad(RICH, "surfaces[0]", "two_sided", 1),
    bad(RICH, "surfaces[1]", "two_sided", True),  # glass
    bad(RICH, "surfaces[7]", "two_sided", True),  # a blend that has glass in it
    bad(RICH, POINT, "position", [0.0, INF, 0.0], 1),
    bad(RICH, POINT, "intensity", [1.0, -1.0, 1.0], 1),
    bad(RICH, POINT, "intensity", []),
    bad(RICH, SPOT, "direction", [0.0, 0.0, 0.0]),
    bad(RICH, SPOT, "cutoff", 0.0),
    bad(RICH, SPOT, "cutoff", 181.0),
    bad(RICH, SPOT, "beam", 45.5),
    bad(RICH, SPOT, "beam", -1.0),
    bad(RICH, SPOT, "intensity", [1.0, NAN, 1.0], 1),
    bad(RICH, DIRECTIONAL, "direction", [0.0, 0.0, 0.0]),
    bad(RICH, DIRECTIONAL, "irradiance", "bright"),
    bad(RICH, MAP, "image", None),
    bad(RICH, MAP, "axes", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]]),
    bad(RICH, MAP, "axes", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.001]]),
    bad(RICH, MAP, "axes", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, NAN, 1.0]], 2, 1),
    bad(RICH, MAP, "axes", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    bad(RICH, "sensor", "aperture_radius", 0.0),
    bad(RICH, "sensor", "focus_distance", -1.0),
    bad(RICH, "sensor", "fov", 180.0),
    bad(RICH, "sensor", "up", [3.0, 0.0, 0.0]),
    bad(HARMONICS, "lights[0]", "coefficients", []),
    bad(HARMONICS, "lights[0]", "coefficients", [[1.0], [0.5]]),
    bad(HARMONICS, "lights[0]", "coefficients", [[1.0], [0.0], [0.0, 0.0], [0.0]], 2),
    bad(HARMONICS, "lights[0]", "coefficients", [[-1.0], [0.0], [0.5], [0.0]], 0, 0),
    bad(HARMONICS, "lights[0]", "coefficients", [[0.0], [0.0], [0.5], [0.0]], 0, 0),
    bad(HARMONICS, "sensor", "normal", [0.0, 0.0, 0.0]),
    bad(HARMONICS, "sensor", "width", 2),
    bad(HARMONICS, "sensor", "height", True),
    bad(METER, "sensor", "direction", [0.0, 0.0, 0.0]),
    bad(METER, "sensor", "height", 0),
    bad(CONSTANT, "sensor", "extent", 0.0),
    bad(CONSTANT, "sensor", "width", 0),
    bad(CONSTANT, "sensor", "target", [0.0, 0.0, 0.0]),
    bad(CONSTANT, "lights[0]", "radiance", [1.0, 1.0, -1.0], 2),
]


def part(parent: str, root: Scene = GOOD) -> Any:
    """The piece of a good scene at a path such as ``surfaces[0].shape``."""
    found: Any = root
    for key, index in re.findall(r"(\w+)(?:\[(\d+)\])?", parent):
        found = getattr(found, key)[int(index)] if index else getattr(found, key)
    return found


def tuples(value: Any) -> Any:
    return tuple(map(tuples, value)) if isinstance(value, list | tuple) else value


@pytest.mark.parametrize("bad", BAD, ids=lambda bad: f"{bad.parent}.{bad.tail}={bad.found!r}"[:60])
def test_the_same_from_python_and_from_json(bad: Bad) -> None:
    owner = part(bad.parent, bad.root)
    with pytest.raises(SceneError) as caught:
        msgspec.structs.replace(owner, **{bad.field: bad.value})
    assert caught.value.path == f"{type(owner).__name__}.{bad.tail}"
    assert repr(tuples(caught.value.found)) == repr(tuples(bad.found))

    prefix = f"{bad.parent}." if bad.parent else ""
    error = refusal(document(bad.root, **{prefix + bad.field: bad.value}))
    assert error.path == prefix + bad.tail
    assert repr(tuples(error.found)) == repr(tuples(bad.found))


def test_every_message_says_path_value_and_expectation() -> None:
    error = refusal(document(**{"surfaces[0].material.albedo": [0.5, 0.5, -3]}))
    assert str(error) == "surfaces[0].material.albedo[2] = -3.0: expected a number in [0, 1]"


PLACES = sorted(
    {
        (("good", "rich", "harmonics", "meter", "constant")[i], bad.parent)
        for bad in BAD
        for i, scene in enumerate([GOOD, RICH, HARMONICS, METER, CONSTANT])
        if bad.root is scene
    }
)


@pytest.mark.parametrize(("scene", "parent"), PLACES)
@pytest.mark.parametrize("name", ["colour", "a.b", "a[0]", ""])
def test_unknown_fields(scene: str, parent: str, name: str) -> None:
    content = document(
        {"good": GOOD, "rich": RICH, "harmonics": HARMONICS, "meter": METER, "constant": CONSTANT}[scene]
    )
    inner: Any = content
    for key, index in re.findall(r"(\w+)|\[(\d+)\]", parent):
        inner = inner[key or int(index)]
    inner[name] = "red"
    error = refusal(content)
    assert error.path == f"{parent}.{name}".removeprefix(".")
    assert error.found == "red"
    known = error.expected.removeprefix("no field of that name; there are ").split(", ")
    assert set(inner) - {"type", name} <= set(known)
