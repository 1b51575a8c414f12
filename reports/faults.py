"""``faults.html``: the matrix of planted faults as a page that needs nothing but itself."""

from __future__ import annotations

from pathlib import Path

from comparisons.faults.matrix import Matrix
from reports.html import environment

PAGE = "faults.html"


def write(matrix: Matrix, folder: Path) -> Path:
    """Write the page into the folder and return its path."""
    path = folder / PAGE
    path.write_text(environment().get_template("faults.html.j2").render(matrix=matrix), encoding="utf-8")
    return path
