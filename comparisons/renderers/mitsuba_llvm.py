"""The LLVM that Mitsuba's ``llvm_*`` variants compile with: found, and looked at before Dr.Jit loads it.

Dr.Jit takes the newest ``libLLVM`` that it finds, or the one that ``DRJIT_LIBLLVM_PATH`` names. One that is too old
ends the process in the middle of a render: ``LLVM ERROR: Cannot select: fminimum``. That was seen with LLVM 15 and 16
(Debian 12); 14 is not taken for one at all; 19 and 22 work. x86 learnt the instruction with LLVM 17.
"""

from __future__ import annotations

import ctypes
import os
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from comparisons.renderers.protocol import RendererFailed

OLDEST = 17
"""The first version that has what Dr.Jit's code needs."""

VARIABLE = "DRJIT_LIBLLVM_PATH"
"""By which a user names the library."""

PLACES = (
    "/usr/lib/*-linux-gnu/libLLVM*.so*",
    "/usr/lib/llvm-*/lib/libLLVM*.so*",
    "/usr/lib64/libLLVM*.so*",
    "/usr/lib/libLLVM*.so*",
    "/opt/homebrew/opt/llvm/lib/libLLVM.dylib",
    "/usr/local/opt/llvm/lib/libLLVM.dylib",
)

_CURE = f"Debian: apt-get install libllvm19; anywhere: {VARIABLE}=/path/to/libLLVM.so"


def ensure_llvm(places: Sequence[str] = PLACES) -> Path:
    """Name to Dr.Jit, in the environment, an LLVM that works. To be called before a variant is set.

    Returns:
        The library.

    Raises:
        RendererFailed: none was found, or the newest is too old; with what was found and what to do.
    """
    named = os.environ.get(VARIABLE)
    if named:
        return _checked(Path(named), f"named by {VARIABLE}")
    found = _newest_first(places)
    if not found:
        raise RendererFailed(f"no LLVM was found, and it needs LLVM {OLDEST} or later. {_CURE}")
    library = _checked(found[0], "the newest that was found")
    os.environ[VARIABLE] = str(library)
    return library


def _newest_first(places: Iterable[str]) -> list[Path]:
    files = {file for place in places for file in Path("/").glob(place.removeprefix("/"))}
    return sorted(files, key=lambda file: (_version_in(file.name), file.name), reverse=True)


def _version_in(name: str) -> int:
    """Of ``libLLVM-19.so`` and ``libLLVM.so.19.1``; 0 where the name has none."""
    match = re.search(r"libLLVM[-.a-z]*(\d+)", name)
    return int(match[1]) if match else 0


def _checked(library: Path, how: str) -> Path:
    version = _version_of(library, how)
    if version is None or version < OLDEST:
        which = f"LLVM {version}" if version else "this LLVM, older than 16,"
        raise RendererFailed(
            f"{which} is too old: {library}, {how}. Dr.Jit's code ends the process with it; expected LLVM {OLDEST} "
            f"or later (19 and 22 are known to work). {_CURE}"
        )
    return library


def _version_of(library: Path, how: str) -> int | None:
    """As it says itself; None where it is too old to say, and its name does not."""
    try:
        loaded = ctypes.CDLL(str(library))
    except OSError as error:
        raise RendererFailed(f"{library}, {how}, can't be loaded as LLVM: {error}. {_CURE}") from None
    if not hasattr(loaded, "LLVMDisposeMessage"):
        raise RendererFailed(f"{library}, {how}, is no LLVM: it has no LLVMDisposeMessage. {_CURE}")
    if not hasattr(loaded, "LLVMGetVersion"):  # since 16
        return _version_in(library.name) or None
    major, minor, patch = ctypes.c_uint(), ctypes.c_uint(), ctypes.c_uint()
    loaded.LLVMGetVersion(ctypes.byref(major), ctypes.byref(minor), ctypes.byref(patch))
    return major.value
