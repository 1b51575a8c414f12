"""Lightproof proves a renderer's light transport right, bounce by bounce."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lightproof.assertion import VerdictError, assert_bounces_match

    __version__: str

__all__ = ["VerdictError", "__version__", "assert_bounces_match"]


def __getattr__(name: str) -> Any:
    """Made when asked for: every pytest on the machine imports this package, and few of them need it."""
    if name == "__version__":
        from importlib.metadata import version

        return version("lightproof")
    if name in __all__:
        from lightproof import assertion

        return getattr(assertion, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
