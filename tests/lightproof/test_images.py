"""The files that images are written to."""

from __future__ import annotations

from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np
import pytest

from scenes.formats import exr

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("command.py"))))
flat, invoke = shared.flat, shared.invoke


@pytest.mark.parametrize(
    "command", [("render", "--spp", "1"), ("answer",)], ids=lambda command: str(command[0])
)
def test_an_image_of_the_user_s_is_not_overwritten(command: tuple[str, ...], tmp_path: Path) -> None:
    """One that a command wrote is, and it says so."""
    out = tmp_path / "x.exr"
    call = (*command, "furnace-box", "--size", "4x4", "--bounces", "1", "--out", out)
    foreign = np.full((1, 2, 2, 3), 7.0)
    exr.write_bounces(out, foreign)
    for content in (out.read_bytes(), b"no image"):
        out.write_bytes(content)
        refused = invoke(*call)
        assert refused.exit_code == 2
        assert "is there already, and may be your own" in flat(refused.output)
        assert out.read_bytes() == content
    out.unlink()
    assert "in place of" not in flat(invoke(*call).output)
    again = invoke(*call)
    assert again.exit_code == 0
    assert "in place of an earlier image" in flat(again.output)
