"""What a renderer's process may take, and how it is ended with all that it has started.

Time: whoever waits for an answer waits so long and no longer.

Memory: the resident memory of the process and its descendants, looked at four times a second. Limits that the
kernel has (``RLIMIT_AS``, ``RLIMIT_DATA``) count what is reserved, and compilers at run time, as LLVM, reserve
gigabytes that they never touch; they also count each process by itself. Between two looks a process may take more
than it should, by what it can fill in that time. Where there is no ``/proc`` (macOS) there is no limit of memory.

The end: a process is the leader of a session, and carries a mark in its environment. Whatever is in that session or
has inherited that mark goes with it, so that neither a process group of its own nor ``setsid`` is a way out.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

MARK = "LIGHTPROOF_WORKER"
"""The environment variable that a worker and all it starts have: the folder for their temporary files."""

LOOK = 0.25
"""Seconds between two looks at how much memory is taken."""

_PROC = Path("/proc")
_CGROUP = (
    Path("/sys/fs/cgroup/memory.max"),
    Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
)


@lru_cache(maxsize=1)
def default_memory() -> int:
    """Half of what the machine has, or of what this process's group is allowed; bytes."""
    found = [os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")]
    for file in _CGROUP:
        with suppress(OSError, ValueError):
            found.append(int(file.read_text()))
    return min(found) // 2


def size(count: float) -> str:
    """A number of bytes, in words."""
    return f"{count / 1e9:.3g} GB" if count >= 1e9 else f"{count / 1e6:.3g} MB"


class Watch:
    """Ends a process that takes too long or too much memory; a context manager around the wait for its answer.

    Attributes:
        verdict: None as long as nothing is wrong; else ``time`` or ``memory``.
    """

    def __init__(
        self,
        pid: int,
        seconds: float,
        memory: int,
        stop: Callable[[], None],
        tidy: Callable[[], None] = lambda: None,
    ) -> None:
        """Of a process, so many seconds and bytes; ``tidy`` is called at each look."""
        self.verdict: str | None = None
        self._pid, self._memory, self._stop, self._tidy = pid, memory, stop, tidy
        self._end = time.monotonic() + seconds
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)

    def _look(self) -> None:
        while not self._done.wait(max(0.0, min(LOOK, self._end - time.monotonic()))):
            if time.monotonic() >= self._end:
                self.verdict = "time"
            elif resident(self._pid) > self._memory:
                self.verdict = "memory"
            if self.verdict:
                self._stop()
                return
            self._tidy()

    def __enter__(self) -> Watch:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._done.set()
        self._thread.join()


def resident(pid: int) -> int:
    """Bytes that a process and its descendants have in memory; 0 where nobody can tell."""
    total = 0
    for member in (pid, *_descendants(pid)):
        with suppress(OSError, ValueError, IndexError):
            total += int((_PROC / str(member) / "statm").read_text().split()[1])
    return total * os.sysconf("SC_PAGE_SIZE")


def _descendants(pid: int) -> Iterator[int]:
    with suppress(OSError):
        for thread in (_PROC / str(pid) / "task").iterdir():
            with suppress(OSError):
                for child in map(int, (thread / "children").read_text().split()):
                    yield child
                    yield from _descendants(child)


def end_all(session: int, mark: str) -> None:
    """End every process of a session, and every one that carries the mark, but this one; again, until there is none.

    Args:
        session: the process that leads it.
        mark: the value of ``MARK``.
    """
    if session != os.getpid():  # at once, and where there is no /proc, all there is
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(session, signal.SIGKILL)
    for _ in range(100):  # what is started while others are ended is seen the next time
        members = list(_members(session, mark))
        for member in members:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(member, signal.SIGKILL)
        if not members:
            return
        time.sleep(0.01)


def _members(session: int, mark: str) -> Iterator[int]:
    """But not those that have ended and only wait to be fetched."""
    carried = f"{MARK}={mark}".encode()
    for folder in _PROC.glob("[0-9]*"):
        pid = int(folder.name)
        if pid == os.getpid():
            continue
        with suppress(OSError, ValueError, IndexError):  # it ended while we looked, or is someone else's
            state, _, _, its_session = (folder / "stat").read_text().rsplit(")", 1)[1].split()[:4]
            if state in "ZX":
                continue
            if int(its_session) == session or carried in (folder / "environ").read_bytes().split(b"\0"):
                yield pid
