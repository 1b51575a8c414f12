"""The keys of a table ``[renderers.NAME]`` in a configuration; ``docs/renderers.md`` shows them in use."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from comparisons.renderers.entry import START_TIMEOUT

WORKER_START_TIMEOUT = 900.0
"""Seconds for a worker file to be ready: the first time, its packages are fetched."""

Arguments = Annotated[list[str], Meta(min_length=1)]
Seconds = Annotated[float, Meta(gt=0, le=1e6)]
"""As long as a budget may be, and no infinity: what hangs has to end."""


class Shared(msgspec.Struct, kw_only=True):
    """Of every renderer.

    Attributes:
        title: one line, for lists.
        install: how to get it, for lists.
        deterministic: it has no noise.
        memory: as ``"4 GB"``: of its process and all it starts; empty for the default.
    """

    title: str = ""
    install: str = ""
    deterministic: bool = False
    memory: str = ""


class Command(Shared, kw_only=True):
    """``command``: any program.

    Attributes:
        command: the program and its arguments, with placeholders; see ``placeholders.py``.
        scene: the format in which it reads scenes, a name in ``scenes.formats.exporters``.
        images: what it writes. ``cumulative``: the sum of bounces 0 … n; ``layers``: a layer per bounce; ``total``:
            the sum of all bounces, since it has no control of depth.
        total: the command as its users run it, without limits of depth; left out: it is not run so.
        coupled: the same seed at two depths shares its paths.
        seed: it takes one.
        timeout: seconds for each call.
        extension: of the image file, by which a program may choose its format.
        env: environment variables, with placeholders.
        version: a text, or the command that prints it.
    """

    command: Arguments
    scene: Literal["json", "mitsuba-xml", "pbrt-v4", "gltf"]
    images: Literal["cumulative", "layers", "total"]
    total: list[str] = []
    coupled: bool = False
    seed: bool = True
    timeout: Seconds = 120.0
    extension: Annotated[str, Meta(pattern=r"^\.[A-Za-z0-9]+$")] = ".exr"
    env: dict[str, str] = {}
    version: str | Arguments = ""


class WorkerFile(Shared, kw_only=True):
    """``worker``: a Python file that speaks ``messages.py``, in an environment of its own.

    Attributes:
        worker: the file.
        python: the interpreter that runs it; left out, uv makes an environment of what the file says in its inline
            metadata (PEP 723).
        start_timeout: seconds until it has to be ready.
        version: of the renderer, for lists; the worker says it itself when it runs.
    """

    worker: str
    python: str = ""
    start_timeout: Seconds = WORKER_START_TIMEOUT
    version: str = ""


class PythonObject(Shared, kw_only=True):
    """``object``: an object with ``render``, or what makes one when it is called.

    Attributes:
        object: ``module:attribute``, imported from the folder of the configuration.
        start_timeout: seconds until it has to be ready.
    """

    object: Annotated[str, Meta(pattern=r"^[^\W\d][\w.]*:[^\W\d][\w.]*$")]
    start_timeout: Seconds = START_TIMEOUT
