from __future__ import annotations

from dataclasses import replace

import pytest
import typer

from lightproof.parameters import check_bounces, percents, size
from scenes import library


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0.5%", (0.005,)),
        ("0.005", (0.005,)),
        ("2 %", (0.02,)),
        ("0.2%, 0.5%,0.01", (0.002, 0.005, 0.01)),
        (None, None),
    ],
)
def test_percents(text: str | None, values: tuple[float, ...] | None) -> None:
    assert percents(text, "--tolerance") == values


@pytest.mark.parametrize("text", ["", "%", "0%", "-1", "nan", "inf%", "1%%", "1%,", "1%,0%"])
def test_no_percents(text: str) -> None:
    with pytest.raises(typer.BadParameter, match="expected a share above 0"):
        percents(text, "--tolerance")


@pytest.mark.parametrize("text", ["0.1", "0.5", "1", "2", "1%,0.5"])
def test_a_large_share_needs_its_sign(text: str) -> None:
    """0.5 would be 50 %, which lets everything pass."""
    with pytest.raises(typer.BadParameter, match=r"is a share, .* %: expected the sign"):
        percents(text, "--tolerance")
    assert percents("50%", "--tolerance") == (0.5,)


@pytest.mark.parametrize("text", ["100%", "500%", "1%,100%"])
def test_a_tolerance_that_black_would_pass(text: str) -> None:
    with pytest.raises(typer.BadParameter, match="expected less than 100%; a black image would pass"):
        percents(text, "--tolerance")


@pytest.mark.parametrize(("text", "value"), [("64x48", (64, 48)), ("1×2", (1, 2)), (None, None)])
def test_size(text: str | None, value: tuple[int, int] | None) -> None:
    assert size(text) == value


@pytest.mark.parametrize("text", ["64", "0x3", "3x", "axb", "-1x3", "64x48x3"])
def test_no_size(text: str) -> None:
    with pytest.raises(typer.BadParameter, match="expected WIDTHxHEIGHT"):
        size(text)


def test_bounces_beyond_the_answer() -> None:
    limited = replace(library.case("furnace-box"), max_bounces=3)
    check_bounces(limited, 3)
    check_bounces(limited, None)
    with pytest.raises(typer.BadParameter, match="holds for bounces 0 to 3"):
        check_bounces(limited, 4)
