"""Names of renderers: ours, the user's, those of installed packages, and objects by module:attribute."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from comparisons.renderers import RendererFailed, canonical, listed, registry, resolve
from comparisons.renderers.config import ConfigError
from comparisons.renderers.process import RendererProcess
from comparisons.renderers.reference import ReferenceRenderer
from scenes import Scene, UnknownNameError, library
from scenes.formats.support import expressible

OWN = '''
import numpy as np

__version__ = "7.1"


class Constant:
    """Everything is as bright as its number."""

    def __init__(self, value=3.0):
        self.value = value

    def render(self, scene, bounces, spp, seed):
        return np.full((len(bounces), *scene.shape), self.value)


class Versioned(Constant):
    def version(self):
        return "7.2"


made = Constant(5.0)
nested = Constant
nested.deep = Versioned(6.0)
number = 4


class Wrong(Constant):
    def render(self, scene, bounces, spp, seed):
        if spp == 1:
            raise SystemExit(3)
        if spp == 2:
            return [[1.0], [2.0, 3.0]]
        if spp == 3:
            raise ValueError("x" * 3_000_000)
        return super().render(scene, bounces, spp, seed)


def words(scene, bounces, spp, seed):
    return "words"


broken = Constant()
broken.render = words
'''


@pytest.fixture
def scene() -> Scene:
    return library.case("furnace-box").scene.resized(4, 3)


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "own.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("name", "version", "value"),
    [("own:Constant", "7.1", 3.0), ("own:made", "7.1", 5.0), ("own:nested.deep", "7.2", 6.0)],
)
def test_an_object_of_the_working_directory(
    own: Path, scene: Scene, spotless: Any, name: str, version: str, value: float
) -> None:
    """A class is called; an object is taken as it is; whoever has no version has that of its module."""
    assert canonical(name) == name
    with RendererProcess(name) as process:
        assert process.version == version
        image = process.render(scene, [0, 2], 1, 0, timeout=60)
    np.testing.assert_array_equal(image, np.full((2, 3, 4, 3), value))


NUMBERED = """
import hashlib
import numpy as np

def numbered(*shape):
    return np.arange(np.prod(shape), dtype=float).reshape(shape)

class Numbered:
    def render(self, scene, bounces, spp, seed):
        digits = int(hashlib.sha256(scene.to_json()).hexdigest()[:4], 16)
        images = [1e6 * k + numbered(*scene.shape) for k in bounces]
        images[0][0, 0] = digits, spp, seed
        return np.array(images)

    def total(self, scene, spp, seed):
        return np.asfortranarray(-numbered(*scene.shape) - 100 * spp - 1000 * seed)

    def first_hits(self, scene):
        return numbered(scene.sensor.height * scene.sensor.width, 5).T
"""


def test_an_object_s_numbers_come_as_they_are(own: Path, spotless: Any) -> None:
    """Its place in the array says what each number is: bounce, row, column, channel; and the scene is ours, whole."""
    (own / "my_numbers.py").write_text(NUMBERED)
    scene = library.case("cornell-box").scene.resized(4, 3)
    place = np.arange(36.0).reshape(3, 4, 3)
    with RendererProcess("my_numbers:Numbered") as process:
        images = process.render(scene, [0, 2, 5], 7, 11, timeout=60)
        total = process.total(scene, 7, 11, timeout=60)
        hits = process.first_hits(scene, timeout=60)
    digits = int(hashlib.sha256(scene.to_json()).hexdigest()[:4], 16)
    np.testing.assert_array_equal(images[0, 0, 0], [digits, 7, 11])
    np.testing.assert_array_equal(images[0].flat[3:], place.flat[3:])
    np.testing.assert_array_equal(images[1:], [2e6 + place, 5e6 + place])
    np.testing.assert_array_equal(total, -place - 11_700)
    np.testing.assert_array_equal(hits, np.arange(60.0).reshape(12, 5).T)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("own:nothing", "own has no nothing; there are np, Constant"),
        ("own:number", "own:number is a int: expected an object with render"),
        ("own:words", r"own:words can't be loaded: TypeError: words\(\) missing 4 required"),
    ],
)
def test_what_is_no_renderer(own: Path, spotless: Any, name: str, message: str) -> None:
    with pytest.raises(RendererFailed, match=message) as caught:
        RendererProcess(name)
    assert bool(caught.value.log) == (name == "own:words"), "a traceback of what is theirs alone"


def test_what_an_object_does_wrong_is_told_and_it_lives_on(own: Path, scene: Scene, spotless: Any) -> None:
    """Whoever leaves, returns what is no array, or has much to say is asked again."""
    with RendererProcess("own:Wrong") as process:
        for spp, message in (
            (1, "^SystemExit: 3$"),
            (2, "^ValueError: setting an array"),
            (3, "^ValueError: x{900,1000} …$"),
        ):
            with pytest.raises(RendererFailed, match=message) as caught:
                process.render(scene, [0], spp, 0, timeout=60)
            assert not caught.value.at_start
            assert (
                "Traceback" in "".join(caught.value.log) or spp == 3
            )  # the end of its line is all that is kept
        assert process.render(scene, [0], 4, 0, timeout=60).max() == 3.0


def test_a_module_that_leaves(own: Path, spotless: Any) -> None:
    (own / "leaving.py").write_text("raise SystemExit('no licence')")
    with pytest.raises(RendererFailed, match="leaving:X can't be loaded: SystemExit: no licence") as caught:
        RendererProcess("leaving:X")
    assert caught.value.at_start


def test_words_are_no_image(own: Path, scene: Scene, spotless: Any) -> None:
    with RendererProcess("own:broken") as process, pytest.raises(RendererFailed, match="values of type <U5"):
        process.render(scene, [0], 1, 0, timeout=60)


def test_a_module_that_is_not_there_is_a_wrong_name(own: Path) -> None:
    """And so is a wrong variant of a renderer of ours."""
    with pytest.raises(UnknownNameError, match="'owm:Constant': there is no module owm here, nor installed"):
        canonical("owm:Constant")
    with pytest.raises(UnknownNameError, match=r"goes by its module, own:Constant, in the folder of own\.py"):
        canonical("./own.py:Constant")
    (own / "mitsuba.py").write_text("raise SystemExit")
    with pytest.raises(UnknownNameError, match="no renderer is called 'mitsuba:scalar_rg'"):
        canonical("mitsuba:scalar_rg")


def test_an_object_of_the_configuration(configured: Any, scene: Scene, spotless: Any, tmp_path: Path) -> None:
    """It is found from the folder of the file, wherever one works."""
    (tmp_path / "own.py").write_text(OWN)
    folder = configured(mine={"object": "own:made", "deterministic": True})
    assert resolve("mine").deterministic
    assert resolve("mine").folder == str(folder)
    with RendererProcess("mine") as process:
        assert process.render(scene, [0], 1, 0, timeout=60).max() == 5.0


def test_an_installed_package_brings_renderers_along(
    own: Path, scene: Scene, spotless: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As an installer leaves it; ours keep their names."""
    installed = own / "own_renderers-1.5.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: own-renderers\nVersion: 1.5\n")
    points = {"fine": "made", "mitsuba": "made", "reference:mis": "made", "../far/away": "made"}
    lines = [f"{name} = own:{attribute}" for name, attribute in points.items()]
    (installed / "entry_points.txt").write_text("\n".join([f"[{registry.GROUP}]", *lines, ""]))
    monkeypatch.syspath_prepend(own)
    monkeypatch.setenv("PYTHONPATH", str(own), prepend=":")
    (own / "elsewhere").mkdir()
    monkeypatch.chdir(own / "elsewhere")

    entry = listed()["fine"]
    assert (entry.title, entry.package) == ("own:made of own-renderers", "own-renderers")
    assert registry.installed(entry) == "1.5"
    assert not {"mitsuba", "../far/away"} & listed().keys()
    assert canonical("mitsuba") == "mitsuba:scalar_rgb"
    assert listed()["reference:mis"].module == "reference"
    with RendererProcess("fine") as process:
        assert process.render(scene, [0], 1, 0, timeout=60).max() == 5.0


def test_a_configuration_that_can_t_be_read_is_no_unknown_name(configured: Any) -> None:
    configured(mine={"command": ["./mine"]})
    with pytest.raises(ConfigError, match=r"renderers\.mine\.scene: missing"):
        canonical("mine")
    assert canonical("reference") == "reference:mis"


# ---- what they support


def test_a_format_supports_what_it_takes() -> None:
    """glTF: triangles, Lambertian; pbrt has no textures; Mitsuba no ellipsoids."""
    gltf, pbrt, mitsuba = (expressible(name) for name in ("gltf", "pbrt-v4", "mitsuba-xml"))
    assert gltf["shapes"] == ("quad", "mesh")
    assert gltf["materials"] == ("lambertian",)
    assert "checkerboard texture" in mitsuba["materials"]
    assert "checkerboard texture" not in pbrt["materials"]
    assert "ellipsoid" in pbrt["shapes"]
    assert "ellipsoid" not in mitsuba["shapes"]
    assert "irradiance_meter" not in mitsuba["sensors"]


def test_everything_that_a_scene_can_hold_is_asked_for() -> None:
    """Every kind of part is among those that formats are tried with, since JSON takes them all."""
    from typing import get_args

    from scenes.lights import AreaLight, Light
    from scenes.materials import Material, Texture
    from scenes.sensor import Camera, Meter
    from scenes.shapes import Shape

    def tags(*kinds: Any) -> set[str]:
        return {kind.__struct_config__.tag for kind in kinds}

    every = expressible("json")
    assert set(every["shapes"]) == tags(*get_args(Shape))
    textures = {f"{tag} texture" for tag in tags(*get_args(Texture))}
    assert set(every["materials"]) == tags(*get_args(Material)) | textures
    assert set(every["lights"]) == tags(AreaLight, *get_args(Light))
    assert set(every["sensors"]) == tags(*get_args(Camera), *get_args(Meter))


def test_what_a_renderer_supports(configured: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    command = ["./mine", "{scene}", "{spp}", "{output}"]
    configured(mine={"command": command, "scene": "gltf", "images": "total", "seed": False})
    said = registry.supports(resolve("mine"))
    assert said["shapes"] == ("quad", "mesh")
    assert (said["images"], said["seed"]) == (("bounce 0", "total"), ("no",))
    assert registry.installed(resolve("mine")) is None
    (tmp_path / "mine").write_text("#!/bin/sh\necho mine 1.2\necho more")
    (tmp_path / "mine").chmod(0o755)
    asking = {
        "command": command,
        "scene": "json",
        "images": "total",
        "seed": False,
        "version": ["./mine", "-V"],
    }
    configured(mine=asking)
    (tmp_path / "below").mkdir()
    monkeypatch.chdir(tmp_path / "below")
    assert registry.installed(resolve("mine")) == "1.2"
    (tmp_path / "mine").write_text(
        "#!/bin/sh\necho no option $1 >&2\nexit 2"
    )  # it is there, and may well render
    assert registry.installed(resolve("mine")) == (
        "unknown: its version can't be had: mine -V: ended with status 2; the last it said was: no option -V"
    )
    reference = registry.supports(resolve("reference"))
    assert "bounces" in reference["images"]
    assert ("total" in reference["images"]) == hasattr(ReferenceRenderer, "total")
