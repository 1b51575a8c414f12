"""Cases of one's own, without touching the package: from a file, or from a package that is installed."""

from __future__ import annotations

import json
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import pytest

from lightproof import cases
from scenes import Scene, library
from scenes.formats import exr

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("command.py"))))
flat, invoke = shared.flat, shared.invoke

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


@pytest.fixture
def own(tmp_path: Path) -> Path:
    (tmp_path / "neighbour.py").write_text("NAME = 'my-sphere'\n")
    file = tmp_path / "own.py"
    file.write_text(OWN)
    return file


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
