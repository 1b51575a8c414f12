"""A program that is run once: in a process group of its own, for so long, and with nothing of it left behind."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from comparisons.renderers.protocol import RendererFailed, RendererTimeout

_SHOWN = 300
"""Characters of a command in a message."""


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
    if not path.is_file():
        raise RendererFailed(f"{path}: there is no such program; has it been built?")
    if not os.access(path, os.X_OK):
        raise RendererFailed(f"{path} can't be run: it is not executable")
    return str(path)


def run(command: Sequence[str], folder: Path, environment: Mapping[str, str], timeout: float) -> None:
    """Run it; what it prints goes where this process prints, the standard input is empty.

    When it has ended, or its time has, whatever else is in its process group is ended as well.

    Args:
        command: the program and its arguments; there is no shell.
        folder: where it works.
        environment: variables besides those of this process.
        timeout: seconds.

    Raises:
        RendererTimeout: it took longer, and was stopped.
        RendererFailed: it can't be started, ended with another status than 0, or by a signal.
    """
    try:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            cwd=folder,
            env={**os.environ, **environment},
            process_group=0,
        )
    except (OSError, ValueError) as error:  # a null byte in an argument is a ValueError
        raise RendererFailed(f"{_shown(command)}: can't be started: {error}") from None
    expired = threading.Event()

    def stop() -> None:
        expired.set()
        _end_group(process.pid)

    timer = threading.Timer(timeout, stop)
    timer.daemon = True
    timer.start()
    try:
        status = process.wait()
    finally:
        timer.cancel()
        _end_group(process.pid)
        process.wait()
    if expired.is_set():
        raise RendererTimeout(f"{_shown(command)}: no image within {timeout:g} s; it was stopped")
    if status:
        how = (
            f"was killed by signal {-status} ({_signal(-status)})"
            if status < 0
            else f"ended with status {status}"
        )
        raise RendererFailed(f"{_shown(command)}: {how}")


def _end_group(leader: int) -> None:
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(leader, signal.SIGKILL)


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return "unknown"


def _shown(command: Sequence[str]) -> str:
    text = " ".join([Path(command[0]).name, *command[1:]])
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]} …"
