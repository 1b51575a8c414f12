"""What the user sees: an HTML page and a JUnit file, rendered from results.json and its EXR images only.

A view never meets live objects, so an old folder renders like a new one, on any machine and without the
renderers that made it.
"""

from __future__ import annotations

from pathlib import Path

from comparisons import results as _results

__all__ = ["JUNIT_FILE", "REPORT_FILE", "render"]

REPORT_FILE, JUNIT_FILE = "report.html", "junit.xml"


def render(folder: Path) -> list[Path]:
    """Write ``report.html`` and ``junit.xml`` into a folder of results.

    Args:
        folder: holds ``results.json`` and the EXR files that it names. An image that is missing or damaged
            does not stop the report: it says so at that place.

    Returns:
        The paths of the two files.

    Raises:
        ResultsError: there is no ``results.json``, or it can't be read.
        OSError: a file can't be written.
    """
    from reports import html, junit  # plots take long to import, and most tests of a renderer make no report

    results = _results.read(folder)
    return [html.write(results, folder), junit.write(results, folder)]
