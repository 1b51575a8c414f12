"""The command adapter contributes nothing: what a program draws is what comparisons see.

The program is ``program.py``, in a process of its own, as always. What it has to draw is written down here by hand.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import OpenImageIO as oiio
import pytest
from numpy.typing import NDArray

from comparisons.renderers import RendererFailed, Unsupported
from comparisons.renderers.command import CommandRenderer
from comparisons.renderers.keys import Command
from comparisons.renderers.pictures import read
from comparisons.renderers.process import RendererProcess
from scenes import (
    AreaLight,
    Dielectric,
    Lambertian,
    Mirror,
    Pinhole,
    PointLight,
    Quad,
    Scene,
    SceneError,
    Sphere,
    Surface,
    library,
)
from scenes.channels import single_channel
from scenes.variations import black, darker

GREY = Lambertian((0.5, 0.5, 0.5))


def lamp(
    name: str, radiance: tuple[float, float, float], x: Sequence[float], y: Sequence[float], z: float
) -> Surface:
    """Its front towards +z; of x and y turned round, towards −z."""
    u, v = (x[1] - x[0], 0.0, 0.0), (0.0, y[1] - y[0], 0.0)
    return Surface(name, Quad((x[0], y[0], z), u, v), GREY, AreaLight(radiance))


# the camera sees a plane z = 0 of 2.5 × 2 in pixels of 0.25 × 0.25, and a plane z = −0.5 that is 1.5 times as large
ASYMMETRIC = Scene(
    (
        lamp("above right", (1.0, 2.0, 4.0), (0.25, 1.0), (0.5, 1.0), 0.0),
        lamp("below left", (16.0, 8.0, 0.5), (-1.25, -1.0), (-1.0, -0.75), 0.0),
        lamp("turned away", (64.0, 64.0, 64.0), (0.0, -0.5), (0.0, 0.25), 0.0),
        lamp("half behind that", (32.0, 16.0, 64.0), (-0.75, 0.0), (0.0, 0.75), -0.5),
    ),
    Pinhole((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 90.0, 10, 8),
)
KNOWN = np.zeros((8, 10, 3))
KNOWN[0:2, 6:9] = 1.0, 2.0, 4.0
KNOWN[7, 0] = 16.0, 8.0, 0.5
KNOWN[2, 3:5] = 32.0, 16.0, 64.0  # and row 3 is black: the back of a lamp covers it


def rendered(process: RendererProcess, bounces: Sequence[int], scene: Scene = ASYMMETRIC, **how: Any) -> Any:
    return process.render(scene, bounces, **{"spp": 16, "seed": 3, "timeout": 60.0, **how})


WAYS: dict[str, tuple[list[str], dict[str, Any]]] = {
    "sums, independent": ([], {}),
    "sums, coupled": (["--shared"], {"coupled": True}),
    "layers": (["--layers", "layers"], {"images": "layers"}),
    "parts": (["--layers", "parts"], {"images": "layers"}),
    "PFM": ([], {"extension": ".pfm"}),
    "TIFF": ([], {"extension": ".tif"}),
}


@pytest.mark.parametrize("way", WAYS)
def test_every_pixel_of_every_bounce(start: Any, way: str) -> None:
    """Camera, rows, columns, channels, units, sides. Bounce k is E / 2ᵏ, so one too many or too few shows."""
    arguments, keys = WAYS[way]
    images = rendered(start(*arguments, **keys), [0, 1, 3], spp=1 << 20)
    np.testing.assert_array_equal(images[0], KNOWN)
    for image, k in zip(images[1:], [1, 3], strict=True):
        np.testing.assert_allclose(image, KNOWN / 2**k, rtol=5e-3)  # the noise is 5e-5 of a term
    for wrong in (KNOWN[::-1], KNOWN[:, ::-1], KNOWN[..., ::-1], np.roll(KNOWN, 1, 0), np.roll(KNOWN, 1, 1)):
        assert not np.allclose(wrong, KNOWN)


def test_the_known_image_is_the_scenes() -> None:
    """By hand, and by the tracer's rays through the centres of pixels: the side of a surface decides."""
    from comparisons.renderers.reference import ReferenceRenderer

    hits = ReferenceRenderer("mis").first_hits(ASYMMETRIC)
    surface, n = hits[4].astype(int), hits[1:4]
    radiance = np.array([s.emission.radiance if s.emission else (0, 0, 0) for s in ASYMMETRIC.surfaces])
    front = (surface >= 0) & (n[2] > 0)  # every ray runs towards −z
    np.testing.assert_array_equal(np.where(front[:, None], radiance[surface], 0).reshape(KNOWN.shape), KNOWN)


def test_one_channel(start: Any) -> None:
    grey = single_channel(ASYMMETRIC, 1)
    np.testing.assert_array_equal(rendered(start(), [0], grey)[0], KNOWN[..., 1:2])


def write(path: Path, pixels: NDArray[np.float64], names: Sequence[str], kind: str = "float") -> Path:
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], len(names), kind)
    spec.channelnames = list(names)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec)
    assert out.write_image(pixels.astype(np.float32))
    out.close()
    return path


def test_a_grey_scene_may_come_in_colours(tmp_path: Path) -> None:
    """Formats that know RGB only have no other grey."""
    file = write(tmp_path / "x.exr", KNOWN, "RGB")
    np.testing.assert_allclose(read(file, False, (8, 10, 1)).images[0, ..., 0], KNOWN.mean(axis=-1))


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("layers", "more than one layer has them: bounce0, bounce1"),
        ("parts", "in each of the parts bounce0, bounce1"),
    ],
)
def test_bounces_are_no_sum(start: Any, kind: str, said: str) -> None:
    """The first of them might be taken for the sum."""
    with pytest.raises(
        RendererFailed, match=rf"{said}\. Did you mean --layers, or images = \"layers\""
    ) as caught:
        rendered(start("--layers", kind), [1])
    assert "wrote something else than the image that was asked for" in str(caught.value)


def test_a_coloured_scene_may_not_come_in_grey(start: Any) -> None:
    with pytest.raises(RendererFailed, match="an image of 1 channels, expected 3"):
        rendered(start("--wrong", "grey"), [0])


@pytest.mark.parametrize(("suffix", "kind"), [(".exr", "half"), (".hdr", "float")])
def test_coarse_numbers_make_no_bounce(start: Any, suffix: str, kind: str) -> None:
    """What they hold by themselves is theirs; a difference of two is not."""
    process = start("--kind", kind, extension=suffix)
    np.testing.assert_allclose(rendered(process, [0])[0], KNOWN, rtol=0.01)
    with pytest.raises(Unsupported, match="write 32-bit floats"):
        rendered(process, [1])


def test_integers_are_no_radiance(tmp_path: Path) -> None:
    with pytest.raises(RendererFailed, match="8-bit integers"):
        read(write(tmp_path / "x.tif", KNOWN, "RGB", "uint8"), False, (8, 10, 3))


# ---- seeds


def calls(file: Path) -> list[tuple[int, int]]:
    """Depth and seed of each call of the program."""
    return [tuple(json.loads(line)[:3:2]) for line in file.read_text().splitlines()]


def test_coupled_depths_share_a_seed(start: Any, tmp_path: Path) -> None:
    process = start("--calls", "calls", coupled=True)
    for seed in (3, 4):
        rendered(process, [0, 2, 3], seed=seed)
    found = calls(tmp_path / "calls")
    first, again = ({seed for _, seed in half} for half in (found[:4], found[4:]))
    assert [depth for depth, _ in found] == [0, 1, 2, 3] * 2
    assert len(first) == len(again) == 1
    assert first != again


def test_uncoupled_depths_have_seeds_of_their_own_that_are_far_apart(start: Any, tmp_path: Path) -> None:
    """Also of consecutive replicates: a program may use seed + pixel."""
    process = start("--calls", "calls")
    for seed in (3, 4, 3):
        rendered(process, [1, 2], seed=seed)
    found = calls(tmp_path / "calls")
    assert [depth for depth, _ in found] == [0, 1, 2] * 3
    assert found[:3] == found[6:], "the same seed has the same images"
    seeds = sorted(seed for _, seed in found[:6])
    assert seeds[0] >= 0
    assert seeds[-1] < 2**31
    assert min(np.diff(seeds)) > 100_000


def test_coupling_takes_the_noise_of_the_sum_away(start: Any) -> None:
    """Bounce 3 is E / 8 with 5 % of noise of its own; uncoupled, it has that of all bounces before."""
    lit = KNOWN > 0

    def noise(process: RendererProcess) -> float:
        return float(np.std(8 * rendered(process, [3], spp=1)[0][lit] / KNOWN[lit]))

    coupled, independent = noise(start("--shared", coupled=True)), noise(start())
    assert 0.03 < coupled < 0.07
    assert independent > 5 * coupled


def test_a_seed_by_the_environment(start: Any) -> None:
    command = [sys.executable, str(Path(__file__).with_name("program.py")), "{scene}", "-o", "{output}"]
    options = ["--spp", "{spp}", "--bounces", "{bounces}"]
    process = start(command=[*command, *options], env={"PROGRAM_SEED": "{seed}"})
    first, again, other = (rendered(process, [1], seed=seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


# ---- without control of depth


def test_without_depth_there_is_emission_and_the_sum(start: Any) -> None:
    process = start(images="total")
    np.testing.assert_array_equal(rendered(process, [0])[0], KNOWN)
    with pytest.raises(Unsupported, match="per-bounce images: it has no control of depth"):
        rendered(process, [0, 1])


def renderer(**keys: Any) -> CommandRenderer:
    """The adapter without its process."""
    program = str(Path(__file__).with_name("program.py"))
    call = [sys.executable, program, "{scene}", "--spp", "{spp}", "--seed", "{seed}", "-o", "{output}"]
    table = {"command": call, "scene": "json", "images": "total"} | keys
    return CommandRenderer(msgspec.json.encode(msgspec.convert(table, Command)).decode())


def test_the_sum_as_its_users_render_it() -> None:
    """E (1 + ½ + ¼ + …) = 2 E."""
    np.testing.assert_allclose(renderer().total(ASYMMETRIC, 1 << 20, 5), 2 * KNOWN, rtol=5e-3)
    depth = [*renderer()._keys.command, "--bounces", "{bounces}"]
    both = renderer(command=depth, images="cumulative", total=renderer()._keys.command)
    np.testing.assert_allclose(both.total(ASYMMETRIC, 1 << 20, 5), 2 * KNOWN, rtol=5e-3)
    np.testing.assert_array_equal(both.render(ASYMMETRIC, [0], 4, 5)[0], KNOWN)
    with pytest.raises(Unsupported, match="has no command for it"):
        renderer(command=depth, images="cumulative").total(ASYMMETRIC, 1, 5)


def test_emission_where_reflectances_can_t_be_scaled() -> None:
    """Glass and mirrors turn black as well; a point light emits no E. The tracer says what E is."""
    from reference_tracer.random_walk import render

    surfaces = (
        *ASYMMETRIC.surfaces,
        Surface("ball", Sphere((0.0, -0.5, 0.2), 0.2), Dielectric()),
        Surface("glass", Quad((0.3, 0.4, 0.3), (0.2, 0.0, 0.0), (0.0, 0.2, 0.0)), Mirror((0.9, 0.9, 0.9))),
    )
    scene = Scene(surfaces, ASYMMETRIC.sensor, (PointLight((0.0, 0.0, 2.0), (1.0, 1.0, 1.0)),))
    with pytest.raises(SceneError):
        darker(scene, 0.0)
    dark = black(scene)
    np.testing.assert_allclose(render(dark, 3, 64, 1).sum(axis=0), render(scene, 0, 64, 1)[0], atol=1e-12)
    assert dark.sensor == scene.sensor


# ---- the files of scenes


def test_what_the_format_lacks_is_named(start: Any) -> None:
    with pytest.raises(
        Unsupported, match="gltf can't express this scene: the back of above right may be seen"
    ):
        rendered(start(scene="gltf"), [0])


def test_what_the_program_lacks_is_named(start: Any) -> None:
    with pytest.raises(Unsupported, match=r"^spheres of glass$"):
        rendered(start("--wrong", "refuse"), [0])


def of_black(*names: str) -> Scene:
    """The lamps of these names, and no surface reflects: then both formats have the sides that are in view."""
    kept = tuple(s for s in ASYMMETRIC.surfaces if s.name in names)
    return black(msgspec.structs.replace(ASYMMETRIC, surfaces=kept))


@pytest.mark.parametrize(
    ("format", "images", "depth"),
    [
        ("pbrt-v4", "cumulative", []),  # the file says it
        ("pbrt-v4", "cumulative", ["{bounces}"]),
        ("pbrt-v4", "total", []),
        ("gltf", "cumulative", ["{bounces}"]),
        ("gltf", "total", ["1000"]),
    ],
)
def test_every_pixel_through_the_other_formats(
    start: Any, format: str, images: str, depth: list[str]
) -> None:
    """Camera, rows, columns, channels, units, sides, depth, and the files that lie beside."""
    program = str(Path(__file__).with_name("drawn_triangles.py"))
    call = [sys.executable, program, "{scene}", "{output}", *depth]
    process = start(command=call, scene=format, images=images, deterministic=True)
    known = KNOWN.copy()
    if format == "gltf":  # it has no backs, so none may be in view, nor in the light of a lamp
        scene, known[2, 3:5] = of_black("above right", "below left"), 0.0
    else:
        scene = of_black(*(surface.name for surface in ASYMMETRIC.surfaces))
    if images == "total":
        np.testing.assert_allclose(process.total(scene, 1, 1, 60), 2 * known, rtol=2e-6)
    else:
        for image, k in zip(rendered(process, [0, 1, 3], scene), [0, 1, 3], strict=True):
            np.testing.assert_allclose(image, known / 2**k, rtol=2e-6)


MITSUBA = """
import sys
import mitsuba
scene, output, spp, depth, seed = sys.argv[1:]
mitsuba.set_variant("scalar_rgb")
loaded = mitsuba.load_file(scene, **({"max_depth": depth} if depth else {}))
image = mitsuba.render(loaded, spp=int(spp), seed=int(seed))
mitsuba.Bitmap(image).write(output)
"""


@pytest.mark.parametrize("depth", ["", "{bounces+1}"], ids=["by the file", "by an option"])
def test_a_renderer_that_reads_mitsubas_files(start: Any, tmp_path: Path, depth: str) -> None:
    """Which counts one more than we do: E, and the ½ᵏ of a furnace."""
    (tmp_path / "render.py").write_text(MITSUBA)
    call = [sys.executable, "render.py", "{scene}", "{output}", "{spp}", depth, "{seed}"]
    process = start(command=call, scene="mitsuba-xml")
    np.testing.assert_allclose(rendered(process, [0])[0], KNOWN, rtol=1e-6)
    images = rendered(process, [0, 1, 2], library.case("furnace-box").scene.resized(8, 8), spp=4096)
    np.testing.assert_allclose(images.mean(axis=(1, 2, 3)), [1.0, 0.5, 0.25], rtol=0.02)
