"""Text that other programs printed, made fit for HTML and XML."""

from __future__ import annotations

import re

_TERMINAL = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(?:\x07|\x1b\\))")
# everything but the characters that XML 1.0 allows (production 2, "Char")
_FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def plain(text: str) -> str:
    """The text without terminal colours and without characters that XML 1.0 forbids."""
    return _FORBIDDEN.sub("", _TERMINAL.sub("", text))
