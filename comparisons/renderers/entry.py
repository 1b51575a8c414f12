"""What is known of a renderer before it is loaded."""

from __future__ import annotations

import msgspec

START_TIMEOUT = 120.0
"""Seconds for a renderer to import its packages."""


class Entry(msgspec.Struct, frozen=True):
    """A renderer that can be asked for. As JSON it goes to the worker process, which needs nothing else to find it.

    Attributes:
        title: one line.
        module, adapter, argument: which class to make, and with what. It is imported in the worker process
            that runs it, and nowhere else.
        package: the distribution that it needs besides this one's own; empty where it comes from no distribution.
        deterministic: whether it has no noise, so that every seed gives the same image.
        one_walk: whether a bounce brings all earlier ones along for nothing.
        differences: whether its bounces from 1 on are differences of independent images, whose noise has both signs.
        last_bounce: beyond which it has none; None for no limit.
        spp_unit: its samples per pixel come in multiples of this.
        seeded: whether it takes a seed; what does not may still have noise.
        folder: where its process works; empty for the user's working directory.
        worker: a command that speaks ``messages.py`` itself, instead of our worker process with an adapter.
        start_timeout: seconds until it has to be ready.
        memory: bytes that its process and all it starts may take; None for the default, see ``limits.py``.
        install: how to get it, where that is not ``pip install package``.
    """

    title: str
    module: str
    adapter: str
    argument: str = ""
    package: str = "lightproof"
    deterministic: bool = False
    one_walk: bool = False
    differences: bool = False
    last_bounce: int | None = None
    spp_unit: int = 1
    seeded: bool = True
    folder: str = ""
    worker: tuple[str, ...] = ()
    start_timeout: float = START_TIMEOUT
    memory: int | None = None
    install: str = ""
