"""Bad input is refused with the path and the value of the field, the same from Python as from JSON."""

from __future__ import annotations

import json
import math
import pickle
import re
from typing import Any, NamedTuple

import msgspec
import pytest

from scenes import (
    AreaLight,
    Blend,
    Checkerboard,
    Conductor,
    ConstantEnvironment,
    Dielectric,
    DirectionalLight,
    Disk,
    Ellipsoid,
    EnvironmentMap,
    Image,
    ImageTexture,
    IrradianceMeter,
    Lambertian,
    Mesh,
    Mirror,
    Orthographic,
    Pinhole,
    PointLight,
    PolarRange,
    Quad,
    RadianceMeter,
    RoughConductor,
    RoughDielectric,
    Scene,
    SceneError,
    Sphere,
    SphericalHarmonicsEnvironment,
    SpotLight,
    Surface,
    ThinLens,
)

GREY = Lambertian((0.5, 0.5, 0.5))
LIGHT = AreaLight((1.0, 2.0, 3.0), PolarRange(10.0, 45.0))
GOOD = Scene(
    (
        Surface("floor", Quad((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), GREY),
        Surface("lamp", Sphere((0.0, 0.0, 3.0), 0.5), GREY, LIGHT),
    ),
    Pinhole((0.0, -4.0, 1.0), (0.0, 0.0, 1.0), (0.0, 0.0, 1.0), 45.0, 8, 6),
)

X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
RGB, PIXELS = (0.1, 0.2, 0.3), Image([[[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]])
TRIANGLES = Mesh(
    [ORIGIN, X, Y, (1.0, 1.0, 0.0)], [[0, 1, 2], [1, 3, 2]], [Z] * 4, [[0, 0], [1, 0], [0, 1], [1, 1]]
)
RICH = Scene(
    (
        Surface("disk", Disk((0.0, 0.0, 1.0), X, Y), Lambertian(Checkerboard(RGB, RGB, 3, 4))),
        Surface("ellipsoid", Ellipsoid(ORIGIN, X, Y, Z), Dielectric()),
        Surface("mesh", TRIANGLES, Lambertian(ImageTexture(PIXELS)), two_sided=True),
        Surface("mirror", Sphere(X, 0.1), Mirror(RGB)),
        Surface("metal", Sphere(X, 0.2), Conductor(RGB, RGB)),
        Surface("rough", Sphere(X, 0.3), RoughConductor(RGB, RGB, 0.1)),
        Surface("frosted", Sphere(X, 0.4), RoughDielectric(0.1)),
        Surface("blend", Sphere(X, 0.5), Blend(Mirror(RGB), Blend(GREY, Dielectric(), 0.2), 0.3)),
    ),
    ThinLens(ORIGIN, X, Y, 45.0, 8, 6, 0.1, 2.0),
    (
        PointLight(X, RGB),
        SpotLight(X, Y, RGB, 45.0, 30.0),
        DirectionalLight(X, RGB),
        EnvironmentMap(PIXELS),
    ),
)
HARMONICS = Scene(
    (), IrradianceMeter(ORIGIN, Z), (SphericalHarmonicsEnvironment([[1.0], [0.0], [0.5], [0.0]]),)
)
CONSTANT = Scene((), Orthographic(ORIGIN, X, Y, 2.0, 8, 6), (ConstantEnvironment(RGB),))
METER = Scene((), RadianceMeter(ORIGIN, Z), (ConstantEnvironment(RGB),))

QUAD, BALL = "surfaces[0].shape", "surfaces[1].shape"
ALBEDO, LAMP, ZONE = "surfaces[0].material", "surfaces[1].emission", "surfaces[1].emission.polar_range"
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


DISK, ELLIPSOID, MESH = (f"surfaces[{i}].shape" for i in range(3))
CHECKS, GLASS, TEXTURE, MIRROR, METAL, ROUGH, FROSTED, BLEND = (f"surfaces[{i}].material" for i in range(8))
POINT, SPOT, DIRECTIONAL, MAP = (f"lights[{i}]" for i in range(4))
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


def document(good: Scene = GOOD, **changes: Any) -> dict[str, Any]:
    """A good scene as a JSON document, with fields changed: ``{"surfaces[0].shape.radius": 0}``."""
    root: dict[str, Any] = json.loads(good.to_json())
    for place, value in changes.items():
        *parents, last = [key or int(index) for key, index in re.findall(r"(\w+)|\[(\d+)\]", place)]
        inner: Any = root
        for key in parents:
            inner = inner[key]
        inner[last] = value
    return root


def refusal(content: dict[str, Any]) -> SceneError:
    with pytest.raises(SceneError) as caught:
        Scene.from_json(json.dumps(content))
    return caught.value


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


def test_names_are_unique() -> None:
    error = refusal(document(**{"surfaces[1].name": "floor"}))
    assert (error.path, error.found) == ("surfaces[1].name", "floor")


def test_something_must_emit() -> None:
    dark = document(**{"surfaces[1].emission": None})
    assert refusal(dark).path == "surfaces"
    assert refusal(dark).found == ["floor", "lamp"]
    assert refusal(document(**{"surfaces[1].emission.radiance": [0, 0, 0]})).path == "surfaces"
    assert refusal(document(surfaces=[])).path == "surfaces"


def test_channels_agree() -> None:
    error = refusal(document(**{"surfaces[1].emission.radiance": [1.0]}))
    assert (error.path, error.found) == ("surfaces[1].emission.radiance", (1.0,))
    one = {"surfaces[1].emission.radiance": [1.0], "surfaces[1].material.albedo": [0.5]}
    error = refusal(document(**one))
    assert (error.path, error.found) == ("surfaces[1].material.albedo", (0.5,))
    assert error.expected == "3 channels, as surfaces[0].material.albedo has"


@pytest.mark.parametrize(
    ("place", "value", "found"),
    [
        (f"{CHECKS}.albedo", [0.5], None),  # what comes first sets the number: the next one is wrong
        (f"{TEXTURE}.albedo.image.pixels", [[[0.25]]], "image.pixels[0][0]"),
        (f"{MIRROR}.reflectance", [0.5], "reflectance"),
        (METAL, {"type": "conductor", "eta": [1.0], "k": [2.0]}, "eta"),
        (ROUGH, {"type": "rough_conductor", "eta": [1.0], "k": [2.0], "alpha": 0.5}, "eta"),
        (f"{BLEND}.first.reflectance", [0.5], "second.first.albedo"),
        (f"{POINT}.intensity", [1.0], "intensity"),
        (f"{SPOT}.intensity", [1.0], "intensity"),
        (f"{DIRECTIONAL}.irradiance", [1.0], "irradiance"),
        (f"{MAP}.image.pixels", [[[0.25]]], "image.pixels[0][0]"),
        (MAP, {"type": "constant", "radiance": [1.0]}, "radiance"),
        (MAP, {"type": "spherical_harmonics", "coefficients": [[1.0]]}, "coefficients[0]"),
    ],
)
def test_channels_agree_in_every_type(place: str, value: Any, found: str | None) -> None:
    error = refusal(document(RICH, **{place: value}))
    if found is None:
        assert error.path == f"{TEXTURE}.albedo.image.pixels[0][0]"
        assert error.expected == f"1 channels, as {CHECKS}.albedo has"
    else:
        part = re.match(r"(surfaces\[\d\]\.material|lights\[\d\])", place)
        assert part is not None
        assert error.path.startswith(part[1])
        assert error.path.endswith(found)
        assert len(error.found) in (1, 3)


def test_one_environment() -> None:
    error = refusal(document(METER, lights=[{"type": "constant", "radiance": [1.0, 1.0, 1.0]}] * 2))
    assert (error.path, error.expected) == ("lights[1]", "no second environment")


def test_a_texture_needs_coordinates() -> None:
    error = refusal(document(RICH, **{f"{MESH}.uv": None}))
    assert (error.path, error.found) == ("surfaces[2].shape.uv", None)


def test_a_texture_does_not_amplify() -> None:
    error = refusal(
        document(RICH, **{f"{TEXTURE}.albedo.image.pixels": [[[0.5, 1.0, 0.5], [0.5, 0.5, 2.0]]]})
    )
    assert (error.path, error.found) == (f"{TEXTURE}.albedo.image.pixels[0][1][2]", 2.0)


@pytest.mark.parametrize("corner", [[0.5, 0.0, 0.0], [0.5, 1e-10, 0.0]])
def test_a_triangle_without_an_area(corner: list[float]) -> None:
    error = refusal(document(RICH, **{f"{MESH}.vertices": [ORIGIN, X, corner, (1.0, 1.0, 0.0)]}))
    assert (error.path, error.found) == (f"{MESH}.triangles[0]", (ORIGIN, X, tuple(corner)))


def test_a_quad_has_no_polar_angles() -> None:
    error = refusal(document(**{"surfaces[0].emission": json.loads(msgspec.json.encode(LIGHT))}))
    assert (error.path, error.found) == ("surfaces[0].emission.polar_range", LIGHT.polar_range)


def test_a_scene_holds_surfaces() -> None:
    with pytest.raises(SceneError, match=r"Scene\.surfaces\[1\] = 'lamp': expected a Surface"):
        Scene((GOOD.surfaces[0], "lamp"), GOOD.sensor)


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


@pytest.mark.parametrize("name", ["fov", "type"])
def test_missing_fields(name: str) -> None:
    content = document()
    del content["sensor"][name]
    error = refusal(content)
    assert (error.path, error.found) == ("sensor", content["sensor"])
    assert error.expected == f"an object with the field {name}"


def test_unknown_types() -> None:
    error = refusal(document(**{"surfaces[0].shape.type": "cube"}))
    assert (error.path, error.found) == ("surfaces[0].shape.type", "cube")
    assert error.expected == "one of quad, disk, sphere, ellipsoid, mesh"
    error = refusal(document(**{"sensor.type": "perspective"}))
    assert error.expected == "one of pinhole, thin_lens, orthographic, radiance_meter, irradiance_meter"


def test_unknown_fields_are_shown_those_of_their_type() -> None:
    error = refusal(document(**{"surfaces[0].material.reflectance": [0.5]}))
    assert error.expected == "no field of that name; there are albedo"
    error = refusal(document(**{"sensor.focal_length": 35.0}))
    assert error.expected == "no field of that name; there are origin, target, up, fov, width, height"


@pytest.mark.parametrize("content", ["", "{", "not JSON", b"\xff\xfe\x00", "[" * 100_000], ids=range(5))
def test_what_is_no_json(content: str | bytes) -> None:
    with pytest.raises(SceneError, match=r"^scene = .*expected JSON"):
        Scene.from_json(content)


def test_the_line_that_is_no_json_is_shown() -> None:
    with pytest.raises(SceneError, match=r"^scene = '\"lights\": \]': expected JSON .*line 3") as caught:
        Scene.from_json('{\n  "surfaces": [],\n  "lights": ]\n}')
    assert caught.value.found == '"lights": ]'


def test_types_are_said_in_words() -> None:
    error = refusal(document(**{"surfaces[0].material.albedo": 0.5}))
    assert error.expected == "an object or a list, such as [0.5, 0.5, 0.5]"
    error = refusal(document(**{"sensor.width": "16"}))
    assert error.expected == "a whole number"


@pytest.mark.parametrize("content", ["[]", "null", "3", '"scene"'])
def test_json_that_is_no_object(content: str) -> None:
    with pytest.raises(SceneError) as caught:
        Scene.from_json(content)
    assert (caught.value.path, caught.value.found) == ("scene", json.loads(content))


def test_the_error_survives_the_way_out_of_a_process() -> None:
    error = pickle.loads(pickle.dumps(SceneError("Sphere.radius", 0.0, "a number > 0")))
    assert str(error) == "Sphere.radius = 0.0: expected a number > 0"
