"""Mitsuba loads what is written, and its image is the one that the adapter makes it give, sample by sample.

Both draw the same random numbers in the same order, so there is no noise between them: pixels agree to the rounding
of single precision, and whatever is one percent off in a file shows.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mitsuba as mi
import msgspec
import numpy as np
import OpenImageIO as oiio
import pytest
from numpy.typing import NDArray

from comparisons.renderers import Unsupported
from comparisons.renderers.mitsuba import MitsubaRenderer
from comparisons.renderers.mitsuba_integrators import Pass, properties
from comparisons.renderers.mitsuba_names import Form
from scenes import (
    Affine,
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
    Sphere,
    SphericalHarmonicsEnvironment,
    SpotLight,
    Surface,
    ThinLens,
    library,
)
from scenes.channels import single_channel
from scenes.formats.export import Source, UnsupportedFeatureError
from scenes.formats.mitsuba_xml import mitsuba_xml

Array = NDArray[np.float64]

GREY = Lambertian((0.5, 0.4, 0.2))
SKY = ConstantEnvironment((1.0, 2.0, 3.0))
POINT = PointLight((0.5, -3.0, 1.0), (9.0, 6.0, 3.0))
WALL = Quad((-1.0, 0.0, -1.0), (2.0, 0.0, 0.0), (0.0, 0.0, 2.0))
PLACE: dict[str, Any] = {"origin": (0.3, -4.0, 0.6), "target": (0.1, 0.0, 0.0), "up": (0.1, 0.0, 1.0)}
CAMERA = Pinhole(**PLACE, fov=25.0, width=12, height=8)
PIXELS = np.random.default_rng(1).random((3, 5, 3))
TEXTURES = {
    "nearest": ImageTexture(Image(PIXELS), "nearest"),
    "bilinear": ImageTexture(Image(PIXELS), "bilinear"),
    "checkerboard": Checkerboard((0.9, 0.5, 0.1), (0.1, 0.2, 0.3), 5, 4),
    "odd checkerboard": Checkerboard((0.9, 0.5, 0.1), (0.1, 0.2, 0.3), 4, 3),
}
CORNERS = [(-1.0, 0.0, -1.0), (1.0, 0.0, -1.0), (1.0, 0.0, 1.0), (-1.0, 0.0, 1.0)]
FLAT = Mesh(CORNERS, [(0, 1, 2), (0, 2, 3)], uv=[(0, 0), (1, 0), (1, 1), (0, 1)])  # type: ignore[arg-type]
BENT = Mesh(CORNERS, [(0, 1, 2), (0, 2, 3)], normals=[(x, -2.0, z) for x, _, z in CORNERS])  # type: ignore[arg-type]
BALL = Sphere((0.0, 0.0, 0.0), 1.2)
AXES = ((0.0, 0.6, 0.8), (1.0, 0.0, 0.0), (0.0, 0.8, -0.6))
METAL = {"eta": (0.2, 0.9, 1.5), "k": (3.9, 2.5, 1.9)}


def one(shape: Any, material: Any = GREY, *lights: Any, sensor: Any = CAMERA, **options: Any) -> Scene:
    """A scene of one surface, lit by a point unless told otherwise."""
    return Scene((Surface("it", shape, material, **options),), sensor, lights or (POINT,))


MAP = EnvironmentMap(Image(PIXELS), AXES)

SCENES = {
    **{f"{name} on a quad": one(WALL, Lambertian(texture)) for name, texture in TEXTURES.items()},
    **{f"{name} on a mesh": one(FLAT, Lambertian(texture)) for name, texture in TEXTURES.items()},
    **{f"{name} on a sphere": one(BALL, Lambertian(texture)) for name, texture in TEXTURES.items()},
    "inside of a sphere": one(Sphere((0.0, 0.0, 0.0), 6.0, inward=True), Lambertian(TEXTURES["nearest"])),
    "disk": one(Disk((0.0, 0.0, 0.0), (0.7, 0.0, 0.0), (0.0, 0.0, 0.7))),
    "shading normals": one(BENT),
    "two-sided": one(Quad(WALL.corner, WALL.edge_v, WALL.edge_u), two_sided=True),
    "mirror": one(WALL, Mirror((0.9, 0.5, 0.2)), SKY),
    "conductor": one(WALL, Conductor(**METAL), SKY),
    "rough conductor": one(WALL, RoughConductor(**METAL, alpha=0.3, shadowing="separable")),
    "dielectric": one(BALL, Dielectric(1.5), MAP),
    "rough dielectric": one(BALL, RoughDielectric(0.3, 1.5, shadowing="separable"), SKY),
    "blend": one(WALL, Blend(GREY, RoughConductor(**METAL, alpha=0.5, shadowing="separable"), 0.3)),
    "spot": one(WALL, GREY, SpotLight((0.2, -3.0, 0.0), (0.0, 1.0, 0.1), (5.0, 4.0, 3.0), 20.0, 10.0)),
    "directional": one(WALL, GREY, DirectionalLight((0.2, 1.0, 0.3), (5.0, 4.0, 3.0))),
    "environment": one(WALL, GREY, SKY),
    "area light": one(WALL, GREY, emission=AreaLight((1.0, 2.0, 3.0))),
    "zone": one(BALL, GREY, emission=AreaLight((5.0, 3.0, 1.0), PolarRange(0.0, 60.0, (0.5, -1.0, 0.5)))),
    "thin lens": one(
        WALL,
        Lambertian(TEXTURES["nearest"]),
        sensor=ThinLens(**PLACE, fov=25.0, width=12, height=8, aperture_radius=0.4, focus_distance=3.0),
    ),
    "wide orthographic": one(
        WALL, Lambertian(TEXTURES["bilinear"]), sensor=Orthographic(**PLACE, extent=1.5, width=12, height=8)
    ),
    "tall orthographic": one(
        WALL, Lambertian(TEXTURES["bilinear"]), sensor=Orthographic(**PLACE, extent=1.5, width=8, height=12)
    ),
    "radiance meter": one(
        WALL, Lambertian(TEXTURES["bilinear"]), sensor=RadianceMeter((0.3, -2.0, 0.1), (0.1, 1.0, 0.2))
    ),
    "far away": one(Sphere((0.0, 30_000.0, 0.0), 9000.0), sensor=CAMERA, emission=AreaLight((1.0, 2.0, 3.0))),
    "environment map": one(BALL, GREY, MAP),
    "mirrored environment map": one(BALL, GREY, EnvironmentMap(Image(PIXELS), (AXES[0], AXES[2], AXES[1]))),
    "environment map of one pixel": one(BALL, GREY, EnvironmentMap(Image([[(1.0, 2.0, 3.0)]]))),  # type: ignore[arg-type]
    "wide spot": one(WALL, GREY, SpotLight((0.2, -1.0, 0.0), (0.5, 0.2, 0.1), (5.0, 4.0, 3.0), 150.0, 30.0)),
    "texture on a sphere with a zone": one(
        BALL, Lambertian(TEXTURES["nearest"]), emission=AreaLight((5.0, 3.0, 1.0), PolarRange(30.0, 90.0))
    ),
    "sheared quad": one(Quad((-0.5, 0.0, -0.5), (1.0, 0.1, 0.0), (0.5, 0.0, 0.8))),
    "sheared lamp": one(
        Quad((-0.5, 0.0, -0.5), (1.0, 0.1, 0.0), (0.5, 0.0, 0.8)), GREY, emission=AreaLight((1.0, 2.0, 3.0))
    ),
    "elliptical disk": one(Disk((0.0, 0.0, 0.0), (0.7, 0.1, 0.0), (0.2, 0.0, 0.4))),
    "elliptical lamp": one(
        Disk((0.0, 0.0, 0.0), (0.7, 0.1, 0.0), (0.2, 0.0, 0.4)), GREY, emission=AreaLight((1.0, 2.0, 3.0))
    ),
}


LIBRARY = {
    name: library.case(name).scene.resized(
        *((12, 12) if library.case(name).scene.shape[:2] != (1, 1) else (1, 1))
    )
    for name in library.CASES
}
BEYOND_MITSUBA = (
    "ellipsoid-over-plane",
    "harmonics-on-sphere",
    "cornell-box-spectral",
    "furnace-equal-energy",
    "furnace-d65",
    "constant-radiance-mirror",
    "constant-radiance-rough",
    "constant-radiance-blend",
)
WITHIN = {name: scene for name, scene in LIBRARY.items() if name not in BEYOND_MITSUBA}


@pytest.fixture(scope="module")
def mitsuba() -> MitsubaRenderer:
    return MitsubaRenderer("scalar_rgb")


# ---- two ways into Mitsuba

DEPTH, SPP, SEED = 6, 4, 3
"""Bounces 0 to 5."""


def from_adapter(mitsuba: MitsubaRenderer, scene: Scene) -> Array:
    path = mitsuba._integrator(properties(Form(), Pass(DEPTH)))
    image = mi.render(mitsuba._load_scene(scene), integrator=path, spp=SPP, seed=SEED)
    return np.array(image, dtype=float)


def from_file(scene: Scene, folder: Path) -> Array:
    """With integrator, sampler and film of the file; shapes in its order, which Mitsuba else leaves to chance."""
    file = folder / "it.xml"
    mitsuba_xml(scene, "it").write(file)
    loaded = mi.load_file(str(file), optimize=False, max_depth=str(DEPTH), spp=str(SPP))
    return np.array(mi.render(loaded, seed=SEED), dtype=float)


def same(image: Array, other: Array) -> bool:
    """But for rounding, which is 2·10⁻⁶ at most where this was written."""
    return image.shape == other.shape and np.allclose(image, other, rtol=1e-4, atol=1e-6 * image.max())


@pytest.mark.parametrize("name", [*WITHIN, *SCENES])
def test_the_file_gives_the_image_of_the_adapter(name: str, mitsuba: MitsubaRenderer, tmp_path: Path) -> None:
    scene = (WITHIN | SCENES)[name]
    adapter, file = from_adapter(mitsuba, scene), from_file(scene, tmp_path)
    assert adapter.any()
    assert same(adapter, file), np.abs(adapter - file).max() / adapter.max()


@pytest.mark.parametrize("name", BEYOND_MITSUBA)
def test_what_the_adapter_refuses_the_file_refuses(name: str, mitsuba: MitsubaRenderer) -> None:
    with pytest.raises(Unsupported):
        from_adapter(mitsuba, LIBRARY[name])
    with pytest.raises(UnsupportedFeatureError):
        mitsuba_xml(LIBRARY[name])


# ---- planted slips

Change = Callable[[Any], Any]


def plain(values: Any) -> Any:
    return tuple(map(plain, values)) if isinstance(values, list) else values


def dimmed(channels: Any) -> Any:
    """The second channel one percent darker."""
    return (channels[0], 0.99 * channels[1], *channels[2:])


def scaled(value: Any) -> Any:
    return plain((0.99 * np.array(value)).tolist())


def turned(vectors: Any) -> Any:
    """By two degrees about an axis that is none of the world's."""
    return plain((np.array(vectors) @ Affine.rotation((1.0, 2.0, 3.0), 2.0).matrix.T).tolist())


SLIPS: dict[str, tuple[tuple[str, ...], Change]] = {
    "a channel of what reflects": (("albedo", "even", "odd", "reflectance", "eta", "k"), dimmed),
    "a channel of what emits": (("radiance", "intensity", "irradiance"), dimmed),
    "pictures": (("pixels",), scaled),
    "parameters of materials": (("alpha", "interior_ior", "weight"), scaled),
    "directions of lights": (("direction", "axis", "axes"), turned),
    "angles of lights": (("cutoff", "beam"), scaled),
}
SENSOR_SLIPS: dict[str, tuple[tuple[str, ...], Change]] = {
    "lengths": (("fov", "extent", "focus_distance", "aperture_radius"), scaled),
    "places": (("origin",), scaled),
    "directions": (("up", "direction"), turned),
}
EXEMPT = {
    "a channel of what reflects": ("far away",),  # the lamp is too far from it
    "parameters of materials": ("glass-ball",),  # under a constant sky any glass is as bright
    "angles of lights": ("spot-beam",),  # all that is in view lies within the beam
    "directions of lights": (
        "spot-beam",
        "environment map of one pixel",
        "texture on a sphere with a zone",  # refused
    ),
}
"""Slips that change nothing in these images, and why."""


def slipped(part: Any, fields: tuple[str, ...], change: Change) -> Any:
    """A part of a scene with a change in each of these fields, wherever it is."""
    changes: dict[str, Any] = {}
    for field in part.__struct_fields__:
        value = getattr(part, field)
        if isinstance(value, msgspec.Struct):
            changes[field] = slipped(value, fields, change)
        elif field in ("surfaces", "lights"):
            changes[field] = tuple(slipped(item, fields, change) for item in value)
        elif field in fields and value is not None:
            changes[field] = change(value)
    return msgspec.structs.replace(part, **changes)


@pytest.mark.parametrize("name", [*WITHIN, *SCENES])
def test_what_is_one_percent_off_in_a_file_shows(name: str, mitsuba: MitsubaRenderer, tmp_path: Path) -> None:
    scene = (WITHIN | SCENES)[name]
    adapter = from_adapter(mitsuba, scene)
    for slip, (fields, change) in SLIPS.items():
        wrong = slipped(scene, fields, change)
        if wrong != scene and name not in EXEMPT.get(slip, ()):
            assert not same(adapter, from_file(wrong, tmp_path)), slip


SEEN_BY = [n for n in SCENES if n.endswith(("orthographic", "thin lens", "meter", "nearest on a quad"))]


@pytest.mark.parametrize("name", SEEN_BY)
def test_a_slip_of_the_sensor_shows(name: str, mitsuba: MitsubaRenderer, tmp_path: Path) -> None:
    scene = SCENES[name]
    adapter = from_adapter(mitsuba, scene)
    for slip, (fields, change) in SENSOR_SLIPS.items():
        wrong = msgspec.structs.replace(scene, sensor=slipped(scene.sensor, fields, change))
        assert wrong == scene or not same(adapter, from_file(wrong, tmp_path)), slip


@pytest.mark.parametrize("name", ["cornell-box-empty", "furnace-channels", "furnace-blend"])
def test_a_slip_in_one_part_alone_shows(name: str, mitsuba: MitsubaRenderer, tmp_path: Path) -> None:
    scene = WITHIN[name]
    adapter = from_adapter(mitsuba, scene)
    for field in ("surfaces", "lights"):
        parts = getattr(scene, field)
        for i, part in enumerate(parts):
            for fields, change in SLIPS.values():
                changed = (*parts[:i], slipped(part, fields, change), *parts[i + 1 :])
                wrong = msgspec.structs.replace(scene, **{field: changed})
                if wrong != scene:
                    assert not same(adapter, from_file(wrong, tmp_path)), (field, i, fields)


# ---- the file itself


def test_the_header_says_what_it_is_and_how_to_render_it(mitsuba: MitsubaRenderer, tmp_path: Path) -> None:
    scene, file = SCENES["environment map"], tmp_path / "my--scene.xml"
    written = mitsuba_xml(scene, "my--scene", Source("case of mine,\nchannel 1", 2)).write(file)
    assert [path.name for path in written] == ["my--scene-0.pfm", "my--scene.xml"]
    text = file.read_text()
    assert "lightproof" in text
    assert "case of mine, channel 1" in text
    assert hashlib.sha256(scene.to_json()).hexdigest() in text
    [command] = [line.partition(": ")[2] for line in text.splitlines() if "mitsuba -m" in line]
    program, *arguments = command.replace("- -", "--").split()
    subprocess.run(
        [Path(sys.executable).with_name(program), *arguments], cwd=tmp_path, check=True, timeout=60
    )
    image = oiio.ImageInput.open(str(tmp_path / "my--scene.exr")).read_image(oiio.FLOAT)
    expected = np.array(mi.render(mi.load_file(str(file), max_depth="3"), spp=256))
    # with other random numbers, since they depend on the number of threads: means have a standard error of 0.3 %
    assert image.shape == expected.shape
    np.testing.assert_allclose(image.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), rtol=0.02)


def test_names_that_xml_would_have_to_quote(mitsuba: MitsubaRenderer, tmp_path: Path) -> None:
    file = tmp_path / 'a $spp & "b".xml'
    main = mitsuba_xml(SCENES["nearest on a mesh"], file.stem).write(file)[-1]
    assert mi.render(mi.load_file(str(main)), spp=1).shape == (8, 12, 3)


def test_one_channel_is_grey() -> None:
    one_channel = single_channel(one(WALL, Lambertian(TEXTURES["bilinear"])), 1)
    grey = ImageTexture(Image(PIXELS[..., [1, 1, 1]]), "bilinear")
    three = one(WALL, Lambertian(grey), PointLight(POINT.position, (6.0, 6.0, 6.0)))
    ours, theirs = (mitsuba_xml(scene, "it") for scene in (one_channel, three))
    assert ours.files == theirs.files
    assert ours.content.partition(b"-->")[2] == theirs.content.partition(b"-->")[2]


def test_parameters_of_the_file(tmp_path: Path, mitsuba: MitsubaRenderer) -> None:
    file = tmp_path / "box.xml"
    assert [p.name for p in mitsuba_xml(library.case("cornell-box").scene).write(file)] == ["box.xml"]
    scene = mi.load_file(str(file), max_depth="3", spp="7")
    assert "max_depth = 3" in str(scene.integrator())
    assert "rr_depth = 1073741824" in str(scene.integrator())
    assert scene.sensors()[0].sampler().sample_count() == 7
    # unless told otherwise it ends: without roulette no path in a closed room does so by itself
    assert "max_depth = 6" in str(mi.load_file(str(file)).integrator())


@pytest.mark.parametrize(
    ("feature", "scene"),
    [
        ("ellipsoid", one(Ellipsoid((0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 1)))),
        ("nearly parallel", one(Disk((0, 0, 0), (1, 0, 0), (1, 0.005, 0)))),
        ("polar", one(Disk((0, 0, 0), (1, 0, 0), (0, 1, 0)), Lambertian(TEXTURES["nearest"]))),
        ("both sides", one(WALL, GREY, emission=AreaLight((1, 1, 1)), two_sided=True)),
        ("angular profile", one(WALL, emission=AreaLight((1, 1, 1), None, ((1, 1, 1), (2, 2, 2))))),
        ("correlated shadowing", one(WALL, RoughConductor(**METAL, alpha=0.3))),
        (
            "spherical harmonics light: Mitsuba has none",
            one(WALL, GREY, SphericalHarmonicsEnvironment(((1.0,) * 3,))),
        ),
        ("irradiance meter", one(WALL, GREY, sensor=IrradianceMeter((0, -1, 0), (0, 1, 0)))),
        ("2 channels", one(WALL, Lambertian((0.5, 0.5)), PointLight((0, -1, 0), (1, 1)))),
        (
            "axis other than z",
            one(
                BALL,
                Lambertian(TEXTURES["nearest"]),
                emission=AreaLight((1, 1, 1), PolarRange(0, 9, (1, 0, 0))),
            ),
        ),
        ("no texture has borders", one(BALL, GREY, emission=AreaLight((1, 1, 1), PolarRange(0, 33.3333)))),
    ],
)
def test_what_mitsuba_lacks_is_named(feature: str, scene: Scene) -> None:
    with pytest.raises(UnsupportedFeatureError, match=feature):
        mitsuba_xml(scene)
