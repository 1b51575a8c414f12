"""What is known of a renderer before it is loaded."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """A renderer that can be asked for.

    Attributes:
        title: one line.
        module, adapter, argument: which class to make, and with what. It is imported in the worker process
            that runs it, and nowhere else.
        package: the distribution that it needs besides this one's own.
        deterministic: whether it has no noise, so that every seed gives the same image.
        one_walk: whether a bounce brings all earlier ones along for nothing.
        last_bounce: beyond which it has none; None for no limit.
        spp_unit: its samples per pixel come in multiples of this.
    """

    title: str
    module: str
    adapter: str
    argument: str
    package: str = "lightproof"
    deterministic: bool = False
    one_walk: bool = False
    last_bounce: int | None = None
    spp_unit: int = 1
