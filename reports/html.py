"""``report.html``: one page that needs nothing but itself. Scripts, styles and pictures are all inside."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from bokeh.core.json_encoder import serialize_json
from bokeh.embed import json_item
from bokeh.resources import Resources
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from comparisons.results import Comparison, Results, TotalResult
from reports import REPORT_FILE, difference, quantities, sections, wording
from reports.plain import plain
from reports.sections import Section

FEW = 6
"""Up to so many comparisons all sections are open, and the table of verdicts is index enough."""

_SYMBOLS = {"pass": "✓", "fail": "✗", "inconclusive": "?", "known": "≈", "unsupported": "–", "error": "!"}
_INDEX = (
    "fail",
    "error",
    "inconclusive",
    "known",
    "unsupported",
    "pass",
)  # who looks for something, looks for these


def write(results: Results, folder: Path) -> Path:
    """Write ``report.html`` into the folder of the results and return its path."""
    parts = [sections.build(c, f"comparison-{i}", folder) for i, c in enumerate(results.comparisons, start=1)]
    library, plots = _embedded(parts)
    checks: list[wording.Result] = [*results.comparisons, *results.relations]
    verdict, outcome = wording.outcome(checks)
    text = (
        environment()
        .get_template("report.html.j2")
        .render(
            results=results,
            sections=parts,
            library=library,
            plots=plots,
            verdict=verdict,
            outcome=outcome,
            counts=wording.counts(checks),
            diagnoses=[(d, wording.diagnosis(d)) for d in results.diagnoses],
            relations=[(r, wording.relation_finding(r)) for r in results.relations],
            meanings=wording.MEANINGS,
            symbols=_SYMBOLS,
            index=_INDEX,
            few=FEW,
            heads=_heads(results),
            totals=list(
                dict.fromkeys(quantities.total_name(t) for c in results.comparisons for t in c.totals)
            ),
            palette=difference.PALETTE,
        )
    )
    path = folder / REPORT_FILE
    path.write_text(text, encoding="utf-8")
    return path


def _heads(results: Results) -> list[tuple[str, str]]:
    """What the columns of the table of verdicts are called: bounces, or the sum that a finished image is."""
    longest = max(results.comparisons, key=lambda c: len(c.bounces), default=None)
    if longest is None:
        return []
    title = "Sum" if quantities.is_sum(longest) else "Bounce {}"
    return [(title.format(b.bounce), quantities.image_name(longest, b.bounce)) for b in longest.bounces]


def _named_totals(comparison: Comparison) -> dict[str, TotalResult]:
    return {quantities.total_name(total): total for total in comparison.totals}


def _embedded(parts: Sequence[Section]) -> tuple[Markup, dict[str, Markup]]:
    """Bokeh's library, and the data of each plot by ``anchor-name``, which ``report.js`` draws when it is looked at.

    Each plot is a document of its own: what Bokeh does for a document grows with the square of its plots.
    """
    figures = {f"{part.anchor}-{name}": plot for part in parts for name, plot in part.figures.items()}
    if not figures:
        return Markup(), {}
    # only the core of BokehJS: widgets, tables and MathJax would triple the page
    library = Resources(mode="inline", components=["bokeh"]).render_js()
    return Markup(library), {name: _data(figure) for name, figure in figures.items()}


def _data(figure: Any) -> Markup:
    """A plot as JSON that may stand in a script: nothing in it ends one, or begins a comment."""
    return Markup(serialize_json(json_item(figure)).replace("<", r"\u003c"))


def environment() -> Environment:
    """What templates are rendered in: texts escaped, numbers as quantities."""
    environment = Environment(
        loader=PackageLoader("reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_finalize,
    )
    environment.filters |= {
        "percent": quantities.percent,
        "interval": quantities.interval,
        "number": quantities.number,
        "date": quantities.date,
        "duration": quantities.duration,
        "term": quantities.term,
        "command": shlex.join,
        "web_link": web_link,
    }
    environment.globals |= {
        "bias": quantities.bias,
        "image_name": quantities.image_name,
        "is_sum": quantities.is_sum,
        "term": quantities.term,
        "partial_sum": quantities.partial_sum,
        "total_name": quantities.total_name,
        "total_finding": wording.total_finding,
        "named_totals": _named_totals,
    }
    return environment


def _finalize(value: Any) -> Any:
    """Every text that the template prints loses its control characters; markup of our own stays as it is."""
    return plain(value) if type(value) is str else value


def web_link(link: str) -> str:
    """The link if it leads to the web, else an empty text: no ``javascript:`` ever becomes an href."""
    try:
        parts = urlsplit(link.strip())
    except ValueError:
        return ""
    return link.strip() if parts.scheme in {"http", "https"} and parts.netloc else ""
