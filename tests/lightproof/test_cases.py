"""Cases and scenes of one's own, without touching the package."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from typer.testing import CliRunner

from comparisons.diagnosis import inquiry
from lightproof import cases
from lightproof.cli import app
from scenes import Scene, library
from scenes.channels import single_channel
from scenes.formats import exr
from scenes.schema import SCHEMA_FILE

OWN = """
from dataclasses import replace

from neighbour import NAME
from scenes import library

def mine():
    return replace(library.case("furnace-sphere"), name=NAME, title="my own")

def bad_name():
    return replace(library.case("furnace-sphere"), name="../up")

def nothing():
    return None

def raises():
    raise ZeroDivisionError("by zero")

number = 7
"""

DECLARED = """
[[deviation]]
case = "my-sphere"
renderer = "reference"
versions = ">=2000"
total = 0.1
within = 0.01
tile_within = 0.01
reason = "none"
link = "none"
"""


def invoke(*arguments: str | Path) -> Any:
    return CliRunner().invoke(app, [str(a) for a in arguments])


def flat(text: str) -> str:
    return " ".join(text.translate(str.maketrans("│╭╮╰╯─", "      ")).split())


def unbroken(text: str) -> str:
    """Without any blanks: a long path may be broken anywhere."""
    return "".join(flat(text).split())


@pytest.fixture
def own(tmp_path: Path) -> Path:
    (tmp_path / "neighbour.py").write_text("NAME = 'my-sphere'\n")
    file = tmp_path / "own.py"
    file.write_text(OWN)
    return file


def small(scene: Scene) -> Scene:
    return scene.resized(8, 8)


def test_a_function_in_a_file_is_a_case(own: Path, tmp_path: Path) -> None:
    place, out, known = f"{own}:mine", tmp_path / "out", tmp_path / "known.toml"
    known.write_text(DECLARED)
    arguments = ("--renderer", "reference", "--size", "8x8", "--jobs", "1", "--no-total", "--out", out)
    arguments = (*arguments, "--known", known)
    result = invoke("validate", "furnace-sphere", "--case", place, "--bounces", "1", *arguments)
    assert result.exit_code == 0, result.output
    assert "[1/2] furnace-sphere × reference: pass" in result.output, "it joins others"
    assert "[2/2] my-sphere × reference: pass" in result.output
    assert result.output.count("declared of versions >=2000 does not apply") == 1, (
        "of it deviations are declared"
    )
    image = tmp_path / "x.exr"
    for command in (("render", "--spp", "1", "--size", "4x4"), ("answer",)):
        assert invoke(*command, "--case", place, "--bounces", "1", "--out", image).exit_code == 0
        assert len(exr.read_bounces(image)[0]) == 2
    assert invoke("export", "--case", place, "--out", tmp_path / "x.json").exit_code == 0
    assert Scene.load(tmp_path / "x.json") == library.case("furnace-sphere").scene


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("render", "--case", "no/such.py:mine"), "no/such.py: there is no such file"),
        (("render", "--case", "{own}"), "expected a file and a function in it, such as my_cases.py:my_case"),
        (("render", "--case", "{own}:mime"), "no function is called 'mime': did you mean mine?"),
        (("render", "--case", "{own}:nothing"), "returned a NoneType: expected a scenes.Case"),
        (("render", "--case", "{own}:number"), "is a int: expected a function that returns a Case"),
        (("render", "--case", "{own}:raises"), "raised ZeroDivisionError: by zero (own.py, line 17)"),
        (("render", "--case", "{own}:bad_name"), "the name '../up' has other characters than"),
        (
            ("render", "--case", "{own}:mine", "furnace-box"),
            "expected a CASE or a scene, my-scene.json, or --case",
        ),
        (("answer",), "expected a CASE or a scene, my-scene.json, or --case, found none"),
        (("answer", "no-such.json"), "no-such.json: No such file"),
        (("answer", "furnace-box", "--spp", "64"), "is a case, which has its answer; it is for a scene"),
        (("check", "x.exr", "--case", "furnace-bx"), "for --case: no case is called 'furnace-bx'"),
        (("validate", "scene.json"), "scene.json is a scene, which has no answer by itself"),
        (("render", "scene.jsn"), "scene.jsn: expected the name of a case, a scene FILE.json, or a function"),
        (("render", "."), ".: expected the name of a case"),
        (
            ("validate", "furnace-box", "--tolerance", "0.5"),
            "'0.5' is a share, 50 %: expected the sign, 0.5%",
        ),
        (("validate", "--scene", "scene.json"), "--scene and --answer belong together"),
        (("validate", "--family", "furnac"), "no family is called 'furnac': did you mean furnace"),
        (("render", "no-such.json"), "no-such.json: No such file"),
        (("export", "furnace-box", "--channel", "3"), "the scene has the channels 0 to 2"),
        (
            ("export", "furnace-box", "--out", "no/such/folder.json"),
            "there is no folder no/such; make it first",
        ),
        (
            ("export", "furnace-box", "--out", "a.obj"),
            "expected a name that ends in one of .json, .xml, .pbrt",
        ),
        (("export", "furnace-box", "--format", "gltf", "--out", "a.xml"), "ends in .gltf, as gltf needs"),
        (
            ("export", "furnace-box", "--format", "obj"),
            "'obj' is not one of 'json', 'mitsuba-xml', 'pbrt-v4'",
        ),
        (("export", "furnace-bx"), "no case is called 'furnace-bx': did you mean furnace-box"),
        (("answer", "furnace-box", "--out", "a.png"), "expected a name that ends in .exr"),
    ],
)
def test_mistakes_are_explained(arguments: tuple[str, ...], complaint: str, own: Path) -> None:
    result = invoke(*(argument.format(own=own) for argument in arguments))
    assert result.exit_code == 2
    shown = flat(result.output).replace(" ", "")  # a long path is broken anywhere
    assert complaint.replace(" ", "") in shown


def test_a_file_that_can_t_be_imported_says_why(tmp_path: Path) -> None:
    file = tmp_path / "broken.py"
    file.write_text("import no_such_package\n")
    with pytest.raises(cases.CaseError, match="ModuleNotFoundError: No module named 'no_such_package'"):
        cases.from_file(f"{file}:mine")


WRONG = """
from dataclasses import replace

import numpy as np

from scenes import Formula, library

def case_with(evaluate):
    return replace(library.case("furnace-box"), name="wrong", answer=Formula(evaluate, source="a guess"))

def flat():
    return case_with(lambda scene, bounces: np.ones((bounces + 1, 3)))

def hollow():
    return case_with(lambda scene, bounces: np.full((bounces + 1, *scene.shape), np.nan))

def negative():
    return case_with(lambda scene, bounces: np.full((bounces + 1, *scene.shape), -0.25))

def deaf():
    return case_with(lambda scene: np.ones(scene.shape))

def rounded():
    return case_with(lambda scene, bounces: [np.ones(scene.shape)] + [np.full(scene.shape, -1e-17)] * bounces)
"""


@pytest.mark.parametrize(
    ("function", "complaint"),
    [
        (
            "flat",
            "its answer has the shape (2, 3): expected (bounces + 1, height, width, channels) = (2, 4, 8, 3)",
        ),
        ("hollow", "its answer is nan in bounce 0, row 0, column 0, channel 0: expected finite radiance ≥ 0"),
        ("negative", "its answer is -0.25 in bounce 0, row 0, column 0, channel 0"),
        ("deaf", "evaluate(scene, bounces=1) of its answer raised TypeError"),
    ],
)
@pytest.mark.parametrize("command", ["validate", "answer"])
def test_a_wrong_answer_is_the_user_s_mistake_and_said_to_be(
    command: str, function: str, complaint: str, tmp_path: Path
) -> None:
    file = tmp_path / "wrong.py"
    file.write_text(WRONG)
    options = ("--size", "8x4", "--bounces", "1", "--jobs", "1", "--out", tmp_path / "out.exr")
    result = invoke(command, "--case", f"{file}:{function}", *options)
    assert result.exit_code == 2
    assert f"wrong.py:{function}: {complaint}" in flat(result.output)
    assert "bug" not in result.output


def test_an_answer_may_be_negative_by_rounding(tmp_path: Path) -> None:
    (tmp_path / "wrong.py").write_text(WRONG)
    found = cases.from_file(f"{tmp_path / 'wrong.py'}:rounded")
    assert found.answer.truth(found.scene, 1) is not None


# ---- entry points


def test_an_installed_package_brings_cases_along(
    own: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A package as an installer leaves it."""
    installed = tmp_path / "own_cases-1.0.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: own-cases\nVersion: 1.0\n")
    points = {"my-sphere": "mine", "broken": "no_such", "other": "mine", "furnace-box": "raises"}
    lines = [f"{name} = own:{function}" for name, function in points.items()]
    (installed / "entry_points.txt").write_text("\n".join([f"[{cases.GROUP}]", *lines, ""]))
    monkeypatch.syspath_prepend(tmp_path)

    assert cases.find("my-sphere").title == "my own"
    rows = {row["name"]: row for row in json.loads(invoke("list", "cases", "--json").output)}
    assert rows["my-sphere"]["title"] == "my own"
    assert "broken = own:no_such of own-cases can't be loaded" in rows["broken"]["title"]
    assert "makes a case called my-sphere" in rows["other"]["title"]
    assert rows["furnace-box"]["truth"] == "exact", "the library's names are its own"
    assert "can't be loaded" in invoke("list", "cases").output
    result = invoke("export", "broken")
    assert result.exit_code == 2
    assert "can't be loaded: AttributeError" in flat(result.output)
    assert "did you mean my-sphere" in flat(invoke("export", "my-spher").output)


# ---- a scene with an answer image


def test_a_scene_with_an_answer_image_is_a_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files as the command itself writes them; a wrong answer fails."""
    monkeypatch.setattr(inquiry, "CASES", 0)  # what is asked about a fail has tests of its own
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    assert invoke("export", "furnace-box", "--size", "8x8", "--out", scene).exit_code == 0
    assert invoke("answer", "furnace-box", "--size", "8x8", "--bounces", "2", "--out", answer).exit_code == 0
    files = ("--scene", scene, "--answer", answer)
    options = ("--renderer", "reference", "--jobs", "1", "--no-total", "--out", tmp_path / "out")
    result = invoke("validate", *files, *options)
    assert result.exit_code == 0, result.output
    assert "room × reference: pass" in result.output
    [comparison] = json.loads((tmp_path / "out" / "results.json").read_bytes())["comparisons"]
    assert comparison["truth"] == "computed"
    assert [b["bounce"] for b in comparison["bounces"]] == [0, 1, 2]
    mean, _ = exr.read_bounces(answer)
    exr.write_bounces(answer, mean * [[[[1.0]]], [[[1.0]]], [[[1.1]]]])
    assert invoke("validate", *files, *options).exit_code == 1


def test_the_noise_of_an_answer_image_is_warned_of(tmp_path: Path) -> None:
    """And whether it comes from the tracer that is judged: only then another strategy takes its place."""
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    files = ("--scene", scene, "--answer", answer)
    options = ("--renderer", "reference", "--jobs", "1", "--budget", "0.1", "--out", tmp_path / "out")

    def notes() -> str:
        invoke("validate", *files, *options)
        [comparison] = json.loads((tmp_path / "out" / "results.json").read_bytes())["comparisons"]
        return " ".join(comparison["notes"])

    assert invoke("render", scene, "--spp", "4", "--bounces", "1", "--out", answer).exit_code == 0
    found = notes()
    assert "The truth is an image of 4 spp without standard errors" in found
    assert "estimated by the reference tracer, which can't judge itself; reference:nee" in found
    mean, _ = exr.read_bounces(answer)
    exr.write_bounces(answer, mean, np.full_like(mean, 0.1), {"lightproof:source": "elsewhere, 4 spp"})
    found = notes()
    assert "without standard errors" not in found
    assert "judge itself" not in found


def test_an_answer_image_says_nothing_of_other_sizes_and_bounces(tmp_path: Path) -> None:
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    exr.write_bounces(answer, np.ones((2, 8, 8, 3)))
    files = ("--scene", scene, "--answer", answer)
    finer = invoke("validate", *files, "--size", "16x16")
    assert finer.exit_code == 2
    assert "room.exr has 8x8 pixels and bounces 0 to 1; it says nothing of 16x16" in flat(finer.output)
    more = invoke("validate", *files, "--bounces", "2")
    assert more.exit_code == 2
    assert "holds for bounces 0 to 1" in flat(more.output)


def test_a_scene_and_an_answer_that_don_t_fit(tmp_path: Path) -> None:
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    exr.write_bounces(answer, np.ones((2, 4, 8, 3)))
    with pytest.raises(cases.CaseError, match=r"\(4, 8, 3\), the scene's sensor has \(8, 8, 3\)"):
        cases.from_answer(scene, answer)
    with pytest.raises(cases.CaseError, match="can't be read"):
        cases.from_answer(scene, tmp_path / "none.exr")
    scene.write_text('{"surfaces": [], "sensor": 3}')
    with pytest.raises(cases.CaseError, match=r"room.json: sensor = 3"):
        cases.from_answer(scene, answer)


# ---- export, answer, choice


def test_a_scene_as_json_renders(tmp_path: Path) -> None:
    scene, out = tmp_path / "my-scene.json", tmp_path / "x.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    result = invoke("render", scene, "--renderer", "reference", "--spp", "2", "--out", out)
    assert result.exit_code == 0, result.output
    mean, _ = exr.read_bounces(out)
    assert mean.shape == (6, 8, 8, 3)
    assert (mean[0] == 1).all()
    assert mean[1].mean() == pytest.approx(0.5, rel=0.1)
    assert invoke("export", scene, "--format", "gltf", "--out", tmp_path / "x.gltf").exit_code == 0
    assert (tmp_path / "x.bin").exists()


BY_HAND = """{
  "surfaces": [
    {
      "name": "floor",
      "shape": {"type": "quad", "corner": [-2, 0, 2], "edge_u": [4, 0, 0], "edge_v": [0, 0, -4]},
      "material": {"type": "lambertian", "albedo": [0.5, 0.25, 0]}
    }
  ],
  "sensor": {
    "type": "pinhole", "origin": [0, 3, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 40, "width": 4, "height": 3
  },
  "lights": [{"type": "directional", "direction": [0, -4, 3], "irradiance": [1, 2, 3]}]
}"""


def test_a_scene_written_by_hand_obeys_the_schema_and_renders(tmp_path: Path) -> None:
    """No program wrote it: whole numbers, fields that are left out. TE = (ρ/π) E⊥ cos θ, cos θ = 4/5."""
    jsonschema.validate(json.loads(BY_HAND), json.loads(SCHEMA_FILE.read_bytes()))
    scene, out = tmp_path / "by-hand.json", tmp_path / "x.exr"
    scene.write_text(BY_HAND)
    result = invoke("render", scene, "--renderer", "reference", "--spp", "2", "--bounces", "2", "--out", out)
    assert result.exit_code == 0, result.output
    mean, _ = exr.read_bounces(out)
    assert mean.shape == (3, 3, 4, 3)
    expected = np.array([0.5, 0.25, 0]) / np.pi * [1, 2, 3] * 0.8
    np.testing.assert_allclose(mean[1], np.broadcast_to(expected, (3, 4, 3)), rtol=1e-6)
    assert not mean[[0, 2]].any()
    jsonschema.validate(json.loads(Scene.load(scene).to_json()), json.loads(SCHEMA_FILE.read_bytes()))


def test_the_answer_is_the_truth(tmp_path: Path) -> None:
    out = tmp_path / "truth.exr"
    result = invoke("answer", "integrating-sphere", "--bounces", "3", "--size", "16x8", "--out", out)
    assert result.exit_code == 0, result.output
    case = library.case("integrating-sphere")
    truth = case.answer.truth(case.scene.resized(16, 8), 3)
    assert truth is not None
    np.testing.assert_allclose(exr.read_bounces(out)[0], truth.mean, rtol=1e-6)
    assert exr.read_attribute(out, "lightproof:source") == truth.source
    assert exr.read_attribute(out, "lightproof:scene") == "integrating-sphere, 16x8 pixels"
    assert exr.read_attribute(out, "lightproof:sha256") == case.scene.resized(16, 8).sha256
    assert invoke("answer", "cornell-box", "--bounces", "2", "--out", out).exit_code == 0
    assert (exr.read_bounces(out)[1] > 0).any(), "an estimate comes with its standard error"


def test_spectra_are_written_with_their_wavelengths(tmp_path: Path) -> None:
    """And read again: as the answer of a scene of one's own they bring their wavelengths along."""
    name, answer = "furnace-equal-energy", tmp_path / "answer.exr"
    size = ("--size", "4x4", "--bounces", "1")
    result = invoke("answer", name, *size, "--out", answer)
    assert "each of 41 wavelengths from 380 to 780 nm and a picture in linear sRGB, exact" in flat(
        result.output
    )
    found = library.case(name)
    assert exr.read_wavelengths(answer) == found.wavelengths
    image = tmp_path / "image.exr"
    result = invoke("render", name, *size, "--spp", "1", "--out", image)
    assert "each of 41 wavelengths" in flat(result.output)
    assert exr.read_wavelengths(image) == found.wavelengths
    assert (exr.read_bounces(image)[0][0] == 1).all()
    (tmp_path / "own.json").write_bytes(found.scene.resized(4, 4).to_json())
    assert cases.from_answer(tmp_path / "own.json", answer).wavelengths == found.wavelengths


def test_export_refuses_what_a_format_lacks(tmp_path: Path) -> None:
    result = invoke("export", "furnace-sphere", "--format", "gltf", "--out", tmp_path / "x.gltf")
    assert result.exit_code == 5
    assert "gltf can't express this scene: sphere is a sphere: glTF has triangles only" in result.output
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", ["json", "xml", "pbrt", "gltf"])
def test_the_suffix_says_the_format(suffix: str, tmp_path: Path) -> None:
    out = tmp_path / f"x.{suffix}"
    result = invoke("export", "furnace-box", "--channel", "1", "--size", "16x8", "--out", out)
    assert result.exit_code == 0, result.output
    if suffix == "json":
        assert Scene.load(out).shape == (8, 16, 1)
    else:  # where it comes from, and how many bounces the case asks for
        text = out.read_text()
        assert "furnace-box, 16x8 pixels, channel 1 of 0 to 2" in text
        scene = single_channel(library.case("furnace-box").scene.resized(16, 8), 1)
        assert scene.sha256 in text
        bounces = library.case("furnace-box").bounces
        said = {
            "xml": f'value="{bounces + 1}"',
            "pbrt": f'maxdepth" [ {bounces} ]',
            "gltf": f'"bounces": {bounces}',
        }
        assert said[suffix] in text


def test_export_overwrites_what_it_wrote_and_nothing_else(tmp_path: Path) -> None:
    def export(*arguments: str | Path) -> Any:
        return invoke("export", "furnace-mesh", "--out", *arguments)

    xml, mesh = tmp_path / "x.xml", tmp_path / "x-0.ply"
    mesh.write_text("a mesh of my own")
    for _ in range(2):
        result = export(xml)
        assert result.exit_code == 2
        assert unbroken("x-0.ply is there already") in unbroken(result.output)
    assert [path.name for path in tmp_path.iterdir()] == ["x-0.ply"]
    assert mesh.read_text() == "a mesh of my own"
    mesh.unlink()
    assert export(xml).exit_code == 0
    assert export(xml, "--size", "4x4").exit_code == 0, "it is ours"
    xml.write_text("<scene/>")
    assert export(xml).exit_code == 2
    (tmp_path / "d.xml").mkdir()
    assert export(tmp_path / "d.xml").exit_code == 2


def test_a_scene_of_ones_own_is_not_overwritten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scene = Path("room.json")
    scene.write_bytes(library.case("furnace-box").scene.to_json())
    content = scene.read_bytes()
    assert invoke("export", scene).exit_code == 0, "the same again does no harm"
    result = invoke("export", scene, "--channel", "1")
    assert result.exit_code == 2
    assert "room.json is there already, and may be your own: give another name" in flat(result.output)
    assert scene.read_bytes() == content


def test_one_channel_of_a_scene(tmp_path: Path) -> None:
    out = tmp_path / "x.json"
    assert invoke("export", "cornell-box", "--channel", "1", "--out", out).exit_code == 0
    assert Scene.load(out).channels == 1


def test_families_and_all(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked: list[list[str]] = []

    def run(chosen: Any, *rest: Any) -> Any:
        asked.append([case.name for case in chosen])
        raise KeyboardInterrupt

    monkeypatch.setattr("lightproof.cli.run_validation", run)
    for arguments in (
        (),
        ("--family", "furnace"),
        ("--family", "furnace", "cornell-box"),
        ("--all", "furnace-box"),
    ):
        assert invoke("validate", *arguments, "--out", tmp_path / "out").exit_code == 130
    default, family, both, everything = asked
    assert tuple(default) == library.DEFAULT
    assert family == [n for n in library.CASES if library.case(n).family == "furnace"]
    assert both == ["cornell-box", *family]
    assert sorted(everything) == sorted(library.CASES)


def test_the_list_says_what_a_case_needs() -> None:
    rows = {row["name"]: row for row in json.loads(invoke("list", "cases", "--json").output)}
    sphere = rows["integrating-sphere"]
    assert sphere["features"] == ["sphere", "inward", "lambertian", "area", "polar_range", "pinhole"]
    assert {"family", "bounces", "truth"} <= sphere.keys()
    assert "polar_range" in invoke("list", "cases").output
