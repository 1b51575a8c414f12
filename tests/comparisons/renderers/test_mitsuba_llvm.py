"""An LLVM that is missing or too old is told before it can end the process."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import pytest

from comparisons.renderers import RendererFailed
from comparisons.renderers.mitsuba_llvm import (
    OLDEST,
    PLACES,
    VARIABLE,
    _newest_first,
    _version_of,
    ensure_llvm,
)
from comparisons.renderers.process import RendererProcess


class Library:
    """What is seen of a loaded LLVM: it says its version, since 16."""

    def __init__(self, version: int | None) -> None:
        self.LLVMDisposeMessage = None
        if version:
            self.LLVMGetVersion = lambda major, minor, patch: setattr(major._obj, "value", version)


@pytest.fixture
def libraries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Makes files that are loaded as LLVM: by name, the version they say."""

    def make(**versions: int | None) -> list[str]:
        made = {name.replace("_", "."): Library(version) for name, version in versions.items()}
        for name in made:
            (tmp_path / name).touch()
        monkeypatch.setattr(ctypes, "CDLL", lambda path: made[Path(path).name])
        return [f"{tmp_path}/libLLVM*.so*"]

    monkeypatch.delenv(VARIABLE, raising=False)
    return make


def test_the_newest_is_named_to_dr_jit(
    libraries: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, "")  # as good as not set; and set back after the test
    places = libraries(**{"libLLVM-9_so": None, "libLLVM_so_19_1": 19, "libLLVM-15_so_1": None})
    assert ensure_llvm(places) == tmp_path / "libLLVM.so.19.1"
    import os

    assert os.environ[VARIABLE] == str(tmp_path / "libLLVM.so.19.1")


@pytest.mark.parametrize(
    ("name", "version", "said"),
    [
        ("libLLVM-15_so_1", None, "LLVM 15 is too old: "),
        ("libLLVM-16_so", 16, "LLVM 16 is too old: "),
        ("libLLVM_so", None, "this LLVM, older than 16, is too old: "),
    ],
)
def test_too_old(libraries: Any, name: str, version: int | None, said: str) -> None:
    with pytest.raises(RendererFailed, match=said) as caught:
        ensure_llvm(libraries(**{name: version}))
    for part in (
        name.replace("_", "."),
        f"expected LLVM {OLDEST} or later",
        "apt-get install libllvm19",
        VARIABLE,
    ):
        assert part in str(caught.value)


def test_what_it_says_counts_and_not_its_name(libraries: Any) -> None:
    assert ensure_llvm(libraries(**{"libLLVM_so": 22})).name == "libLLVM.so"


def test_none_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    with pytest.raises(RendererFailed, match="no LLVM was found, and it needs LLVM 17 or later"):
        ensure_llvm([f"{tmp_path}/libLLVM*.so*"])


def test_the_one_that_is_named_counts(
    libraries: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    places = libraries(**{"libLLVM_so_19_1": 19, "libLLVM-16_so": 16})
    monkeypatch.setenv(VARIABLE, str(tmp_path / "libLLVM-16.so"))
    with pytest.raises(
        RendererFailed, match=r"LLVM 16 is too old: .*libLLVM-16.so, named by DRJIT_LIBLLVM_PATH"
    ):
        ensure_llvm(places)


@pytest.mark.parametrize(
    ("library", "complaint"),
    [
        ("libc.so.6", "libc.so.6, named by DRJIT_LIBLLVM_PATH, is no LLVM"),
        ("/nowhere/libLLVM.so", "/nowhere/libLLVM.so, named by DRJIT_LIBLLVM_PATH, can't be loaded as LLVM"),
    ],
)
def test_a_real_process_says_so(monkeypatch: pytest.MonkeyPatch, library: str, complaint: str) -> None:
    monkeypatch.setenv(VARIABLE, library)
    with pytest.raises(RendererFailed, match=complaint):
        RendererProcess("mitsuba:llvm_ad_rgb")


def test_those_of_this_machine_are_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each by itself, in a process of its own: one that is too old fails cleanly, the others render."""
    files = {file.resolve() for file in _newest_first(PLACES)}
    for file in sorted(files):
        monkeypatch.setenv(VARIABLE, str(file))
        version = _version_of(file, "")
        if version is not None and version >= OLDEST:
            RendererProcess("mitsuba:llvm_ad_rgb").close()
        else:
            with pytest.raises(RendererFailed, match="is too old"):
                RendererProcess("mitsuba:llvm_ad_rgb")
