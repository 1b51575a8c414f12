"""The page of verdicts: ``python docs/verdicts.py FOLDER…`` writes docs/verdicts.md, renderer × case.

Each folder holds the results.json of a run, ``lightproof validate --all --renderer NAME… --out FOLDER``; ``make
verdicts`` makes them all. A renderer that was run more than once counts with the last run.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from comparisons import results
from comparisons.renderers import RENDERERS
from comparisons.renderers.mitsuba_names import is_of_family, shown
from comparisons.results import Comparison, Results
from scenes import library

MARKS = {"pass": "✓", "known": "k", "fail": "**✗**", "error": "!", "inconclusive": "?", "unsupported": "·"}

_HEAD = """# Verdicts

Renderers held against every case that they can express, at the case's own tolerance. `make verdicts` makes the page;
with `BUDGET="--budget 60"` fewer verdicts stay open.

- ✓ pass: every bounce, over the image and its tiles, is inside its tolerance, α = 0.1 %;
- k known: it deviates as declared in comparisons/known.toml; [findings](findings/README.md) say why;
- **✗** fail: some bounce is outside; · unsupported: it lacks a feature; ! error;
- ? inconclusive: the budget was used up first.

The second sign is of the row `total`, the sum of all bounces by the renderer's own defaults; none where there is no
such sum. Where a sign is no ✓, the list below says which bounce, by how much, or what is missing.
"""


def page(runs: Sequence[Results]) -> str:
    """The page, in Markdown."""
    found = {(c.renderer, c.case): c for run in runs for c in run.comparisons}
    renderers = list(dict.fromkeys(name for name, _ in found))
    cases = [name for name in library.CASES if any((r, name) in found for r in renderers)]
    return "\n".join(
        [
            _HEAD,
            *_made_by(runs),
            "",
            *_table(found, renderers, cases),
            "",
            "## What is not a pass",
            "",
            *_reasons(found, renderers, cases),
            "",
        ]
    )


def _made_by(runs: Sequence[Results]) -> Iterator[str]:
    versions = {(c.renderer.partition(":")[0], c.renderer_version) for run in runs for c in run.comparisons}
    names = ", ".join(f"{name} {version}" for name, version in sorted(versions) if version)
    dates = sorted(run.provenance.date[:10] for run in runs)
    budgets = sorted({run.provenance.budget for run in runs})
    days = dates[0] if dates[0] == dates[-1] else f"{dates[0]} to {dates[-1]}"
    yield f"{names}; {days}, {', '.join(f'{b:g}' for b in budgets)} s per case and renderer."


def _table(
    found: dict[tuple[str, str], Comparison], renderers: Sequence[str], cases: Sequence[str]
) -> Iterator[str]:
    yield "| # | renderer |"
    yield "|---|---|"
    for i, name in enumerate(renderers, 1):
        yield f"| {i} | `{name}` |"
    yield ""
    yield "| case |" + "".join(f" {i} |" for i in range(1, len(renderers) + 1))
    yield "|---|" + "---|" * len(renderers)
    for case in cases:
        signs = (_signs(found.get((name, case))) for name in renderers)
        yield f"| {case} |" + "".join(f" {sign} |" for sign in signs)


def _signs(comparison: Comparison | None) -> str:
    if comparison is None:
        return ""
    bounces = [b.verdict for b in comparison.bounces]
    whole = next((v for v in ("fail", "inconclusive", "known") if v in bounces), comparison.verdict)
    if bounces and all(v == "pass" for v in bounces):
        whole = "pass"
    totals = [t.verdict for t in comparison.totals if t.verdict != "unsupported"]
    return MARKS[whole] + (" " + MARKS[totals[-1]] if totals else "")


def _reasons(
    found: dict[tuple[str, str], Comparison], renderers: Sequence[str], cases: Sequence[str]
) -> Iterator[str]:
    for name in renderers:
        reasons: dict[str, list[str]] = {}
        for case in cases:
            comparison = found.get((name, case))
            if comparison is not None and (why := _why(comparison)):
                reasons.setdefault(why, []).append(case)
        if reasons:
            yield f"`{name}`\n"
            yield from (f"- {', '.join(of)}: {why}" for why, of in reasons.items())
            yield ""


def _why(comparison: Comparison) -> str:
    """What is not right, in a clause; empty where all is."""
    if comparison.verdict in ("unsupported", "error"):
        return f"{comparison.verdict}: {comparison.message}"
    wrong = [b for b in comparison.bounces if b.verdict in ("fail", "known")]
    said = [
        f"bounce {b.bounce} {b.verdict} by {_percent(b.worst_tile.bias if b.decided_by == 'tile' else b.bias)}"
        + (" in a tile" if b.decided_by == "tile" else f" ± {100 * b.standard_error:.1g} %")
        for b in wrong
    ]
    said += [
        f"total {t.verdict} by {_percent(t.result.bias)}"
        for t in comparison.totals
        if t.verdict in ("fail", "known") and t.result is not None
    ]
    said += [f"{t.verdict}: {t.message}" for t in comparison.totals if t.verdict in ("inconclusive", "error")]
    left_open = [str(b.bounce) for b in comparison.bounces if b.verdict == "inconclusive"]
    return "; ".join([*said, *([f"bounces {', '.join(left_open)} open"] if left_open else [])])


def _percent(bias: float) -> str:
    return f"{float(f'{100 * bias:.2g}'):+g} %"  # two digits, and no exponent


def names() -> list[str]:
    """Every renderer that is in the table: the tracer's strategies, each form of Mitsuba, and the OpenGL witness."""
    own = [name for name in RENDERERS if not is_of_family(name)]
    return [*own, *(form.name for form in shown())]


if __name__ == "__main__":
    if sys.argv[1:] == ["--names"]:
        print(*names(), sep="\n")
        raise SystemExit
    runs = [results.read(Path(folder)) for folder in sys.argv[1:]]
    Path(__file__).with_suffix(".md").write_text(page(runs))
