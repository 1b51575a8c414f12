"""A worker file: it speaks ``messages.py`` itself, in an environment of its own, so there is no adapter to load.

Its Python, or uv, is started in the place of our worker process; ``docs/workers.md`` has the protocol.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import msgspec


def installed(argument: str, folder: Path) -> str | None:
    """Its version as its configuration says; None where there is nothing to run it with."""
    start, version = msgspec.json.decode(argument, type=list[str])
    there = (folder / start).is_file() if os.sep in start else shutil.which(start) is not None
    return (version or "unknown") if there else None
