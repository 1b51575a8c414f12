"""The folder that a run writes: results.json, the report and the images."""

from __future__ import annotations

import shutil
from pathlib import Path

import typer

import reports
from comparisons.results import RESULTS_FILE


def prepare(out: Path) -> None:
    """Make the folder; what an earlier run left goes, so that the folder holds one run.

    Raises:
        typer.BadParameter: it can't be written.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        if (out / RESULTS_FILE).exists():
            shutil.rmtree(out / "images", ignore_errors=True)
            for name in (RESULTS_FILE, reports.REPORT_FILE, reports.JUNIT_FILE):
                (out / name).unlink(missing_ok=True)
    except OSError as error:
        message = f"{error.filename}: {error.strerror}; expected a folder that can be written"
        raise typer.BadParameter(message, param_hint="--out") from None
