"""The user's configuration: where it is found, and what is said of what can't be."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path

import numpy as np
import pytest

from comparisons.crew import Crew
from comparisons.probe import Probe
from comparisons.renderers import ConfigError, Images, RendererFailed, config, limits, resolve
from comparisons.renderers.command import CommandRenderer
from comparisons.renderers.config import load
from comparisons.renderers.placeholders import filled
from scenes import library

COMMAND = [
    "./mine",
    "{scene}",
    "--spp",
    "{spp}",
    "--seed",
    "{seed}",
    "--bounces",
    "{bounces}",
    "-o",
    "{output}",
]
"""As the documentation has it."""


def written(folder: Path, text: str, name: str = config.FILE) -> Path:
    (folder / name).write_text(text)
    return folder / name


def table(**changes: str) -> str:
    keys = {"command": str(COMMAND).replace("'", '"'), "scene": '"json"', "images": '"cumulative"'} | changes
    return "\n".join(["[renderers.mine]", *(f"{key} = {value}" for key, value in keys.items() if value)])


def test_what_is_said_is_kept(tmp_path: Path) -> None:
    text = table(
        title='"My own"', memory='"1.5 GB"', images='"layers"', deterministic="true", install='"make"'
    )
    found = load(written(tmp_path, f'memory = "500 MB"\n{text}'))
    assert found.memory == 500_000_000
    entry = found.renderers["mine"]
    assert (entry.title, entry.install, entry.memory) == ("My own", "make", 1_500_000_000)
    assert (entry.one_walk, entry.deterministic, entry.seeded) == (True, True, True)
    assert entry.folder == str(tmp_path)
    independent, coupled = (table(coupled=said) for said in ("false", "true"))
    for said, differences in ((text, False), (independent, True), (coupled, False)):
        assert load(written(tmp_path, said)).renderers["mine"].differences == differences
    assert (entry.module, entry.adapter) == ("command", "CommandRenderer")


def test_it_is_found_in_the_folders_above(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The nearest one counts; a project that says nothing of Lightproof is passed over."""
    below = tmp_path / "a" / "b"
    below.mkdir(parents=True)
    assert config.find(below) is None
    project = written(
        tmp_path, "[tool.lightproof]\n" + table().replace("[ren", "[tool.lightproof.ren"), config.PYPROJECT
    )
    assert config.find(below) == project
    assert list(load(project).renderers) == ["mine"]
    written(below, "[tool.other]\n", config.PYPROJECT)
    assert config.find(below) == project
    nearer = written(tmp_path / "a", table())
    assert config.find(below) == nearer
    monkeypatch.chdir(below)
    config._read.cache_clear()
    assert resolve("mine").folder == str(tmp_path / "a")
    assert resolve("mine").memory == resolve("reference").memory == limits.default_memory()
    config._read.cache_clear()


def call(*names: str) -> str:
    """A command with these placeholders."""
    return str(["./m", *(f"{{{name}}}" for name in names)]).replace("'", '"')


WRONG = {
    "no TOML": ("memory = ", "expected TOML: "),
    "an unknown key": ('memorry = "4 GB"', "memorry: no key is called 'memorry': did you mean memory?"),
    "no size": ("memory = 4", 'memory = 4: expected a size such as "500 MB" or "4 GB"'),
    "no table": ("renderers = 3", "renderers = 3: expected a table of renderers, [renderers.NAME]"),
    "a renderer that is none": (
        "renderers.mine = 3",
        "renderers.mine = 3: expected a table with one of the keys",
    ),
    "a name with parts": ('[renderers."my:own"]', "'my:own': expected a name of letters, digits"),
    "no kind": (
        table(command=""),
        "mine: expected one of the keys command, worker, object, mitsuba; found scene, images",
    ),
    "two kinds": (
        table(worker='"x.py"'),
        "expected one of the keys command, worker, object, mitsuba; found command and worker",
    ),
    "a mistyped key": (
        table(imgaes='"layers"'),
        "renderers.mine.imgaes: no key is called 'imgaes': did you mean images?",
    ),
    "a missing key": (
        table(images=""),
        'renderers.mine.images: missing; expected "cumulative" or "layers" or "total"',
    ),
    "another format": (table(scene='"obj"'), 'renderers.mine.scene = \'obj\': expected "gltf" or "json"'),
    "a command line": (table(command='"./mine {scene}"'), "expected a list of texts, at least one"),
    "an empty command": (
        table(command="[]"),
        "renderers.mine.command = []: expected a list of texts, at least one",
    ),
    "no end": (table(timeout="inf"), "mine.timeout = inf: expected a number > 0, and no more than 1,000,000"),
    "an empty program": (table(command='[""]'), "mine.command: '' is no program: expected ./mine, or a name"),
    "a program to be filled in": (table(command='["{scene}"]'), "command: '{scene}' is no program"),
    "no program for the total": (table(total='[""]'), "mine.total: '' is no program"),
    "an empty version": (
        table(version="[]"),
        "mine.version = []: expected a text or a list of texts, at least",
    ),
    "no plugin kind": (
        '[renderers.mine]\nmitsuba = "scalar_rgb"\nbdsf = {}',
        "bdsf: no key is called 'bdsf': did you",
    ),
    "plugins in a row": (
        '[renderers.mine]\nmitsuba = "scalar_rgb"\nbsdf = 3',
        "renderers.mine.bsdf = 3: expected a table of tables, each by the type of what it stands in for",
    ),
    "a plugin in words": (
        '[renderers.mine]\nmitsuba = "scalar_rgb"\nsampler = "mine"',
        "renderers.mine.sampler = 'mine': expected a table with the type of a plugin",
    ),
    "a wrong plugin": (
        '[renderers.mine]\nmitsuba = "scalar_rgb"\nbsdf.difuse = {}',
        "renderers.mine: bsdf: no bsdf plugin of the adapter is called 'difuse': did you mean diffuse?",
    ),
    "no time": (table(timeout="0"), "renderers.mine.timeout = 0: expected a number > 0"),
    "not true": (table(coupled='"yes"'), "renderers.mine.coupled = 'yes': expected true or false"),
    "no variables": (table(env='["A"]'), "renderers.mine.env = ['A']: expected a table of texts"),
    "no extension": (
        table(extension='"exr"'),
        "renderers.mine.extension = 'exr': expected an extension such as",
    ),
    "no version": (table(version="1.2"), "renderers.mine.version = 1.2: expected a text or a list of texts"),
    "no scene": (
        table(command=call("output", "spp", "seed", "bounces")),
        "renderers.mine.command: {scene} is missing",
    ),
    "no output": (table(command=call("scene", "spp", "seed", "bounces")), "{output} is missing: without it"),
    "no samples": (table(command=call("scene", "output", "seed", "bounces")), "{spp} is missing: sampling"),
    "no seed": (
        table(command=call("scene", "output", "spp", "bounces")),
        "{seed} is missing: replicates are",
    ),
    "no depth": (table(command=call("scene", "output", "spp", "seed")), "{bounces} is missing: images ="),
    "a seed after all": (table(seed="false"), "{seed} is there, and seed = false says"),
    "a depth after all": (table(images='"total"'), '{bounces} is there: images = "total" says'),
    "a limit as users render": (
        table(total=call("scene", "output", "spp", "seed", "bounces")),
        "mine.total: {bounces} is there",
    ),
    "an unknown placeholder": (
        table(command=call("scene", "out")),
        "{out} in '{out}' is no placeholder: there are {scene}, {output}",
    ),
    "a format": (table(command=call("scene", "spp:04d")), "{spp:04d} in '{spp:04d}' is no placeholder"),
    "a depth less": (
        table(command=call("scene", "bounces-1")),
        "{bounces-1} in '{bounces-1}' is no placeholder",
    ),
    "half a brace": (table(command='["./m", "{scene"]'), "a brace by itself is written {{ or }}"),
    "an unknown variable's": (
        table(env='{A = "{sead}"}'),
        "renderers.mine.env.A: {sead} in '{sead}' is no placeholder",
    ),
    "coupled layers": (
        table(images='"layers"', coupled="true"),
        "renderers.mine.coupled = True: expected false",
    ),
    "no worker file": (
        '[renderers.mine]\nworker = "x.py"',
        "renderers.mine.worker = 'x.py': expected a file: there is none at",
    ),
    "no object": (
        '[renderers.mine]\nobject = "x.py"',
        "renderers.mine.object = 'x.py': expected module:attribute",
    ),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_can_t_be(tmp_path: Path, what: str) -> None:
    """The file, the key, what stands there, and what may."""
    text, message = WRONG[what]
    file = written(tmp_path, text)
    with pytest.raises(ConfigError) as caught:
        load(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert message in str(caught.value)


RIGHT = {
    "a seed in the environment": table(
        command=call("scene", "output", "spp", "bounces"), env='{SEED = "{seed}"}'
    ),
    "no seed": table(command=call("scene", "output", "spp", "bounces"), seed="false"),
    "no noise": table(command=call("scene", "output", "bounces"), deterministic="true"),
    "a depth in the file": table(command=call("scene", "output", "spp", "seed"), scene='"pbrt-v4"'),
    "one more": table(command=call("scene", "output", "spp", "seed", "bounces+1")),
    "no depth": table(command=call("scene", "output", "spp", "seed"), images='"total"'),
    "braces": table(command='["./m", "{{x}}", "{scene}", "{output}", "{spp}", "{seed}", "{bounces}"]'),
}


@pytest.mark.parametrize("what", RIGHT)
def test_what_can_be(tmp_path: Path, what: str) -> None:
    assert "mine" in load(written(tmp_path, RIGHT[what])).renderers


def test_placeholders_are_filled() -> None:
    values = {"scene": Path("/a b/scene.json"), "bounces": 4, "spp": 16}
    assert filled("--in={scene}", values) == "--in=/a b/scene.json"
    assert filled("{bounces+1}{{{spp}}}", values) == "5{16}"


def test_an_integrator_of_one_s_own_does_not_end_where_mitsuba_s_does(
    configured: Callable[..., Path],
) -> None:
    mine = {"type": "mine", "max_depth": "{max_depth}"}
    configured(
        mine={"mitsuba": "scalar_rgb:direct", "integrator": mine},
        theirs={"mitsuba": "scalar_rgb:direct", "title": "as it is"},
    )
    assert (resolve("mine").last_bounce, resolve("theirs").last_bounce) == (None, 1)
    assert resolve("mine").title == "mitsuba:scalar_rgb:direct with integrator mine"
    assert resolve("theirs").title == "as it is"


def test_a_name_of_ours_is_taken(configured: Callable[..., Path]) -> None:
    configured(mitsuba={"command": COMMAND, "scene": "json", "images": "cumulative"})
    with pytest.raises(
        ConfigError, match=r"toml: renderers\.mitsuba: expected a name that is not one of ours"
    ):
        resolve("mine")


def test_a_program_that_is_not_there(configured: Callable[..., Path], tmp_path: Path) -> None:
    """Relative paths begin at the file; what has no path is looked for where programs are."""
    folder = configured(mine={"command": COMMAND, "scene": "json", "images": "cumulative"})
    argument = resolve("mine").argument
    with pytest.raises(RendererFailed, match=f"{folder}/mine: there is no such program; has it been built"):
        CommandRenderer(argument)
    assert resolve("mine").install == "make or install ./mine"
    (folder / "mine").mkdir()
    with pytest.raises(RendererFailed, match=f"{folder}/mine is a folder: expected a program"):
        CommandRenderer(argument)
    (folder / "mine").rmdir()
    (folder / "mine").write_text("print('without a first line')")
    with pytest.raises(RendererFailed, match=r"is not executable; try chmod \+x"):
        CommandRenderer(argument)
    os.chmod(folder / "mine", 0o755)
    renderer = CommandRenderer(argument)
    with pytest.raises(
        RendererFailed, match=r"Exec format error: .*; a script begins with #! and its interpreter"
    ):
        renderer.render(library.case("furnace-box").scene.resized(2, 2), [0], 1, 0)
    configured(mine={"command": ["no-such-program", *COMMAND[1:]], "scene": "json", "images": "cumulative"})
    with pytest.raises(
        RendererFailed, match=r"no such program on the PATH; one beside the file is \./no-such"
    ):
        CommandRenderer(resolve("mine").argument)


class Same:
    """Renders the same image whatever the seed."""

    jobs = 1

    def render(self, *_: object) -> Future[Images]:
        future: Future[Images] = Future()
        future.set_result(np.ones((2, 8, 8, 3)))
        return future


def test_without_a_seed_the_same_image_is_no_replicate(configured: Callable[..., Path]) -> None:
    """What's missing is said, once it is seen; a program with noise of its own needs no seed."""
    command = [argument for argument in COMMAND if argument not in ("--seed", "{seed}")]
    mine = {"command": command, "scene": "json", "images": "cumulative", "seed": False}
    configured(mine=mine, sure={**mine, "deterministic": True})
    complaint = Probe(Same(), 60.0).complaint("mine")
    assert "What's missing: {seed} in its command or its environment" in str(complaint)
    assert Probe(Same(), 60.0).complaint("sure") is None


def test_who_is_not_there_was_asked_for_nothing(configured: Callable[..., Path]) -> None:
    """What was asked for is said where it may be to blame, and there alone."""
    call = [sys.executable, "-c", "raise SystemExit(3)", *COMMAND[1:]]
    configured(
        gone={"command": COMMAND, "scene": "json", "images": "cumulative"},
        wrong={"command": call, "scene": "json", "images": "cumulative"},
    )
    with Crew(1) as crew:
        gone, wrong = (str(Probe(crew, 60.0).complaint(name)) for name in ("gone", "wrong"))
    assert gone.endswith("has it been built?")
    assert wrong.endswith(
        "ended with status 3 (asked for the Cornell box, which tells whether it heeds its seed)"
    )
