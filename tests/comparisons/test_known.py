from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from comparisons import known
from comparisons.renderers import canonical
from scenes import Tolerance, library

ENTRY = """
[[deviation]]
case = "furnace-box"
renderer = "mitsuba:scalar_rgb"
versions = ">=3.9,<3.10"
bounces = [1, 2]
bias = [0.01, 0.02]
within = 0.001
tile_within = 0.01
reason = "r"
link = "l"
"""


def test_shipped_entries_name_cases_and_renderers_that_exist_and_a_page_that_exists() -> None:
    entries = known.load(known.SHIPPED)
    assert entries
    for entry in entries:
        for name in entry.renderers:
            assert "*" in name or canonical(name) == name
        assert (Path(__file__).parents[2] / entry.link).exists()
        if entry.relation is not None:
            continue
        case = library.case(entry.case)
        assert case.bounces >= min(entry.bounces)
        truth = case.answer.truth(case.scene, 19)
        assert truth is not None
        for k in range(1, 20):  # however many are asked for
            assert entry.speaks_of(k) == truth.mean[k].any()


def test_entries_apply_to_their_case_renderer_and_versions(tmp_path: Path) -> None:
    file = tmp_path / "known.toml"
    file.write_text(ENTRY)
    entries = known.load(file)
    [found] = known.declared(entries, "furnace-box", "mitsuba:scalar_rgb", "3.9.1")
    assert [found.speaks_of(k) for k in range(4)] == [False, True, True, False]
    assert found.biases(2, "RG") == {"R": 0.02, "G": 0.02}
    assert not known.declared(entries, "furnace-box", "mitsuba:scalar_rgb", "3.10.0")
    for version in ("3.10.0", "unknown"):
        [said] = known.of_other_versions(entries, "furnace-box", "mitsuba:scalar_rgb", version)
        assert said.endswith(f"declared of versions >=3.9,<3.10 does not apply: this one's is {version}")
    assert not known.of_other_versions(entries, "furnace-box", "mitsuba:scalar_rgb", "3.9.1")
    assert not known.of_other_versions(entries, "furnace-box", "reference:mis", "3.10.0")
    assert not known.declared(entries, "furnace-sphere", "mitsuba:scalar_rgb", "3.9.1")
    assert not known.declared(entries, "furnace-box", "reference:mis", "3.9.1")


@pytest.mark.parametrize(
    ("renderer", "meant", "others"),
    [
        (
            '"mitsuba:*"',
            ["mitsuba:scalar_rgb", "mitsuba:llvm_ad_rgb:ptracer", "mitsuba:scalar_rgb:path:ldsampler"],
            ["reference:mis"],
        ),
        (
            '"mitsuba:*:path:*"',
            ["mitsuba:scalar_rgb", "mitsuba:llvm_ad_rgb", "mitsuba:llvm_ad_rgb:path:ldsampler"],
            ["mitsuba:llvm_ad_rgb:ptracer", "reference:mis"],
        ),
        (
            '["mitsuba", "mitsuba:llvm_ad_rgb:path:independent"]',
            ["mitsuba:scalar_rgb", "mitsuba:llvm_ad_rgb"],
            ["mitsuba:scalar_spectral", "mitsuba:scalar_rgb:path:stratified"],
        ),
    ],
)
def test_an_entry_can_be_about_several_renderers(
    tmp_path: Path, renderer: str, meant: list[str], others: list[str]
) -> None:
    file = tmp_path / "known.toml"
    file.write_text(ENTRY.replace('"mitsuba:scalar_rgb"', renderer))
    [entry] = known.load(file)
    assert [name for name in meant + others if entry.means(name)] == meant
    for name in meant + others:
        assert bool(known.declared([entry], "furnace-box", name, "3.9.1")) == (name in meant)


def test_an_entry_of_a_relation_says_nothing_of_the_comparison(tmp_path: Path) -> None:
    file = tmp_path / "known.toml"
    of_room = ENTRY.replace("furnace-box", "room")  # no case, but a scene that relations bring along
    file.write_text(ENTRY + ENTRY + 'relation = "scaling"\n' + of_room + 'relation = "channels"\n')
    plain, scaling, channels = entries = known.load(file)

    def found(case: str, relation: str | None = None) -> list[known.Deviation]:
        return known.declared(entries, case, "mitsuba:scalar_rgb", "3.9.1", relation)

    assert found("furnace-box") == [plain]
    assert found("furnace-box", "scaling") == [scaling]
    assert found("room", "channels") == [channels]
    assert found("room") == found("room", "scaling") == []


def test_the_last_bias_can_hold_onwards(tmp_path: Path) -> None:
    file = tmp_path / "known.toml"
    file.write_text(ENTRY + "onwards = true\n")
    [entry] = known.load(file)
    assert [entry.speaks_of(k) for k in (0, 2, 3, 9)] == [False, True, True, True]
    assert [entry.biases(k, "R") for k in (1, 2, 3, 9)] == [{"R": 0.01}] + 3 * [{"R": 0.02}]


def test_channels_can_deviate_differently(tmp_path: Path) -> None:
    file = tmp_path / "known.toml"
    file.write_text(ENTRY.replace("0.02]", '[0.02, -0.03]]\nchannels = ["B", "R"]'))
    [entry] = known.load(file)
    assert entry.biases(1, "RGB") == {"B": 0.01, "R": 0.01}
    assert entry.biases(2, "RGB") == {"B": 0.02, "R": -0.03}
    assert entry.biases(2, "R") == {"R": -0.03}


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (("bounces = [1, 2]\nbias = [0.01, 0.02]\n", ""), "expected bounces and bias, or total"),
        (('link = "l"', 'link = "l"\ntotal = 0.01'), "total stands by itself: expected no bounces"),
        (("bounces = [1, 2]\nbias = [0.01, 0.02]", "total = 0.001"), "total = 0.001, within = 0.001"),
        (("bounces = [1, 2]\nbias = [0.01, 0.02]", "total = 0.1\nonwards = true"), "total stands by itself"),
        (("bounces = [1, 2]\nbias = [0.01, 0.02]", "total = [0.1]"), "one for each of the channels"),
        (("[0.01, 0.02]", "[0.01]"), "bias has 1 numbers, bounces has 2"),
        ((">=3.9,<3.10", "three"), "versions = 'three'"),
        (('reason = "r"\n', ""), "missing required field `reason`"),
        (('link = "l"', 'link = "l"\nsize = 3'), "unknown field `size`"),
        (("within = 0.001", "within = 0"), "within = 0"),
        (("within = 0.001", "within = 0.02"), "0 < within < |bias|"),
        (("bias = [0.01, 0.02]", "bias = [nan, 0.02]"), "bias = [nan, 0.02]"),
        (
            ("0.02]", "[0.02, 0.03]]"),
            "bias = [0.01, [0.02, 0.03]], channels = None: expected a number for each",
        ),
        (("0.02]", '[0.02]]\nchannels = ["R", "G"]'), "with one for each of the channels"),
        (("0.02]", '[0.02, 0.001]]\nchannels = ["R", "G"]'), "0 < within < |bias|"),
        (("0.02]", "[]]\nchannels = []"), "channels = []"),
        (("bounces = [1, 2]", "bounces = [2, 2]"), "bounces = [2, 2]: expected each once"),
        (("bounces = [1, 2]", "bounces = [-1, 2]"), "bounces = [-1, 2]"),
        (
            ('"furnace-box"', '"furnace-bax"'),
            "deviation[0]: no case is called 'furnace-bax': did you mean furnace-box",
        ),
        (("mitsuba:scalar_rgb", "mitsuba:scalar"), "deviation[0]: no renderer is called 'mitsuba:scalar'"),
        (("mitsuba:scalar_rgb", "mitsuba:*:paths:*"), "no renderer is called 'mitsuba:*:paths:*'"),
        (('link = "l"', 'link = "l"\nrelation = "scales"'), "deviation[0]: no relation is called 'scales'"),
        (
            ('"furnace-box"', '"attic"\nrelation = "scaling"'),
            "deviation[0]: no scene is called 'attic'",
        ),
        (("[[deviation]]", "[[deviation]"), "known.toml"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path: Path, change: tuple[str, str], complaint: str) -> None:
    file = tmp_path / "known.toml"
    file.write_text(ENTRY.replace(*change))
    with pytest.raises(known.KnownError, match=r"known\.toml") as caught:
        known.load(file)
    assert complaint in str(caught.value)


def test_a_case_of_the_users_own_has_to_be_named_to_be_spoken_of(tmp_path: Path) -> None:
    file = tmp_path / "known.toml"
    file.write_text(ENTRY.replace("furnace-box", "attic"))
    [entry] = known.load(file, ["attic"])
    assert known.declared([entry], "attic", "mitsuba:scalar_rgb", "3.9.1") == [entry]
    file.write_text(ENTRY.replace("furnace-box", "attic") + 'relation = "scaling"\n')
    assert known.load(file, ["attic"])
    assert known.load(file, scenes=["attic"])
    with pytest.raises(known.KnownError, match="no scene is called 'attic'"):
        known.load(file, ["cellar"], ["loft"])


def test_a_scene_has_no_answer_to_deviate_from(tmp_path: Path) -> None:
    file = tmp_path / "known.toml"
    for scene in ("attic", "room"):
        file.write_text(ENTRY.replace("furnace-box", scene))
        with pytest.raises(known.KnownError, match=f"no case is called '{scene}'"):
            known.load(file, scenes=["attic", "room"])


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "known.toml"
    file.write_bytes(b"\xff\xfe")
    with pytest.raises(known.KnownError, match=r"known\.toml"):
        known.load(file)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(known.KnownError, match="No such file"):
        known.load(tmp_path / "none.toml")


def of_sum(bounces: list[int], bias: Any, means: Any, **changes: Any) -> known.DeclaredSum | None:
    fields: dict[str, Any] = {
        "case": "furnace-box",
        "renderer": "mitsuba",
        "versions": "==3.9.*",
        "within": 0.001,
        "tile_within": 0.01,
        "reason": "r",
        "link": "l",
    }
    entry = known.Deviation(bounces=bounces, bias=bias, **(fields | changes))
    return known.declared_of_sum([entry], np.array(means), ["R", "G"], Tolerance((0.005,), (0.02,)))


def test_what_bounces_declare_is_weighted_by_their_light() -> None:
    """R has 4 + 3 + 1, G 1 + 1 + 2: bounce 1 is 3/8 and 1/4 of them, bounce 2 1/8 and 1/2."""
    found = of_sum([1, 2], [0.02, 0.04], [[4, 1], [3, 1], [1, 2]])
    assert found is not None
    assert found.biases(2, ["R", "G"]) == {
        "R": pytest.approx(0.375 * 0.02 + 0.125 * 0.04),
        "G": pytest.approx(0.25 * 0.02 + 0.5 * 0.04),
    }
    # what no entry speaks of may use its tolerance: half of the light of R, bounce 0
    assert found.within == pytest.approx(0.5 * 0.005 + 0.375 * 0.001 + 0.5 * 0.001)
    assert found.tile_within == pytest.approx(0.5 * 0.02 + 0.375 * 0.01 + 0.5 * 0.01)
    assert "bounces 1, 2 explains it" in found.reason


def test_of_one_channel_and_of_later_bounces() -> None:
    found = of_sum([1], [[0.03]], [[1, 1], [1, 1], [2, 2]], channels=["G"], onwards=True)
    assert found is not None
    assert found.biases(2, ["R", "G"]) == {"G": pytest.approx(0.75 * 0.03)}


def test_what_is_declared_of_the_sum_itself_counts_before_what_bounces_explain(tmp_path: Path) -> None:
    file = tmp_path / "known.toml"
    of_total = ENTRY.replace("bounces = [1, 2]\nbias = [0.01, 0.02]", 'total = [-0.05]\nchannels = ["G"]')
    file.write_text(of_total + ENTRY)
    entries = known.load(file)
    assert not any(entries[0].speaks_of(k) for k in range(9))
    found = known.declared_of_sum(entries, np.ones((3, 2)), ["R", "G"], Tolerance((0.005,), (0.02,)))
    assert found == known.DeclaredSum({"G": -0.05}, 0.001, 0.01, "r", "l")


def test_without_a_declared_bounce_nothing_is_declared_of_the_sum() -> None:
    assert of_sum([7], [0.02], [[1, 1], [1, 1]]) is None
