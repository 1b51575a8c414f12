"""The end of a command that can't go on."""

from __future__ import annotations

from typing import NoReturn

import typer


def stop(message: str, status: int, log: list[str] | None = None) -> NoReturn:
    """Say why on the standard error, after what was heard last, and end with that exit status."""
    for line in [*(log or []), f"Error: {message}"]:
        typer.echo(line, err=True)
    raise typer.Exit(status)
