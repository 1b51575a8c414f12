"""A program that is run once: in a process group of its own, for so long, and with nothing of it left behind."""

from __future__ import annotations

import errno
import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from comparisons.renderers.protocol import RendererFailed, RendererTimeout, Unsupported

UNSUPPORTED = "unsupported:"
"""How the last line begins that a program prints to refuse a scene; the feature it lacks follows."""

_END = 4000
"""Bytes of what a program prints that are kept to find its last line in."""

_LINGER = 1.0
"""Seconds to wait for what is still to be read when a program has ended."""

_SHOWN = 300
"""Characters of a command, or of what it said, in a message."""


def executable(name: str, folder: Path) -> str:
    """Where a program is: a path begins at the folder, a name alone is looked for on the ``PATH``.

    Raises:
        RendererFailed: there is no such program, or it may not be run.
    """
    if os.sep not in name:
        found = shutil.which(name)
        if found is None:
            raise RendererFailed(
                f"{name}: there is no such program on the PATH; one beside the file is ./{name}"
            )
        return found
    path = Path(name).expanduser()
    path = path if path.is_absolute() else folder / path
    if path.is_dir():
        raise RendererFailed(f"{path} is a folder: expected a program")
    if not path.is_file():
        raise RendererFailed(f"{path}: there is no such program; has it been built?")
    if not os.access(path, os.X_OK):
        raise RendererFailed(f"{path} can't be run: it is not executable; try chmod +x")
    return str(path)


def asked(command: Sequence[str], folder: Path, timeout: float) -> str:
    """What a command prints that is asked for a line of text, such as its version.

    Args:
        command, folder, timeout: as of ``run``.

    Raises:
        RendererFailed: it can't be started, took longer, or ended with another status than 0.
    """
    try:
        found = subprocess.run(
            [executable(command[0], folder), *command[1:]],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=timeout,
            cwd=folder,
        )
    except subprocess.TimeoutExpired:
        raise RendererFailed(f"{_shown(command)}: no answer within {timeout:g} s") from None
    except (OSError, ValueError) as error:
        raise RendererFailed(f"{_shown(command)}: can't be started: {error}") from None
    said = found.stdout + found.stderr
    if found.returncode:
        raise RendererFailed(f"{_shown(command)}: {_how(found.returncode)}{_heard(_last_line(said))}")
    return said


def run(command: Sequence[str], folder: Path, environment: Mapping[str, str], timeout: float) -> None:
    """Run it; what it prints goes to the standard error of this process, its own standard input is empty.

    When it has ended, or its time has, whatever else is in its process group is ended as well.

    Args:
        command: the program and its arguments; there is no shell.
        folder: where it works.
        environment: variables besides those of this process.
        timeout: seconds.

    Raises:
        Unsupported: it ended with another status than 0, and with a line ``unsupported: FEATURE``.
        RendererTimeout: it took longer, and was stopped.
        RendererFailed: it can't be started, ended with another status than 0, or by a signal.
    """
    try:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env={**os.environ, **environment},
            process_group=0,
        )
    except (OSError, ValueError) as error:  # a null byte in an argument is a ValueError
        script = "; a script begins with #! and its interpreter" if _is_no_program(error) else ""
        raise RendererFailed(f"{_shown(command)}: can't be started: {error}{script}") from None
    expired = threading.Event()

    def stop() -> None:
        expired.set()
        _end_group(process.pid)

    timer, said = threading.Timer(timeout, stop), _Said(process)
    timer.daemon = True
    timer.start()
    try:
        status = process.wait()
    finally:
        timer.cancel()
        _end_group(process.pid)
        process.wait()
    last = said.last_line()
    if expired.is_set():
        raise RendererTimeout(f"{_shown(command)}: no image within {timeout:g} s; it was stopped")
    if status > 0 and last.startswith(UNSUPPORTED):
        raise Unsupported(last.removeprefix(UNSUPPORTED).strip())
    if status:
        raise RendererFailed(f"{_shown(command)}: {_how(status)}{_heard(last)}")


class _Said:
    """Hands on what a program prints, as it comes, and keeps its end."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        assert process.stdout is not None
        self._pipe, self._end = process.stdout, b""
        self._thread = threading.Thread(target=self._hand_on, daemon=True)
        self._thread.start()

    def _hand_on(self) -> None:
        with self._pipe:
            while some := os.read(self._pipe.fileno(), 1 << 16):
                self._end = (self._end + some)[-_END:]
                os.write(2, some)

    def last_line(self) -> str:
        """That is not empty."""
        self._thread.join(_LINGER)  # a child that has left the process group may still hold the pipe
        return _last_line(self._end.decode(errors="replace"))


def _last_line(text: str) -> str:
    return next((line.strip() for line in reversed(text.split("\n")) if line.strip()), "")


def _how(status: int) -> str:
    if status < 0:
        return f"was killed by signal {-status} ({_signal(-status)})"
    return f"ended with status {status}"


def _heard(last: str) -> str:
    return f"; the last it said was: {_cut(last)}" if last else ""


def _is_no_program(error: Exception) -> bool:
    return isinstance(error, OSError) and error.errno == errno.ENOEXEC


def _end_group(leader: int) -> None:
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(leader, signal.SIGKILL)


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return "unknown"


def _shown(command: Sequence[str]) -> str:
    return _cut(" ".join([Path(command[0]).name, *command[1:]]))


def _cut(text: str) -> str:
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]} …"
