"""A comparison as an assertion, for the test suites of renderers.

def test_direct_light(lightproof):
    lightproof.assert_bounces_match(MyRenderer(), "furnace-box", tolerance="0.5%")
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import reports
from comparisons.renderers import Renderer
from comparisons.results import Comparison, Results
from comparisons.settings import DEFAULT_ALPHA, Silent
from lightproof import arguments
from lightproof.arguments import Shares
from lightproof.explanation import explanation, headline
from lightproof.host import Host, Unsupported
from lightproof.validate import compare
from scenes import Case, UnknownNameError


class VerdictError(AssertionError):
    """The verdict is ``fail``, ``inconclusive`` or ``error``, or ``unsupported`` where that must not be.

    Attributes:
        comparison: what was found.
        report: the page that shows it.
    """

    def __init__(self, message: str, comparison: Comparison, report: Path) -> None:
        super().__init__(message)
        self.comparison, self.report = comparison, report


VerdictError.__module__ = "lightproof"  # as one imports it, and as pytest prints it


def assert_bounces_match(
    renderer: str | Renderer,
    case: str | Case,
    tolerance: Shares | None = None,
    *,
    tile_tolerance: Shares | None = None,
    bounces: int | None = None,
    size: tuple[int, int] | str | None = None,
    budget: float | None = None,
    alpha: float = DEFAULT_ALPHA,
    seed: int = 0,
    unsupported: Unsupported | None = None,
    report: str | Path | None = None,
) -> Comparison:
    """Hold a renderer against a case whose every bounce is known; anything but agreement raises.

    Args:
        renderer: the name of a registered one, such as ``mitsuba``, which runs in processes of its own; or any
            object with the methods of ``comparisons.renderers.Renderer``, which is called here and now.
        case: a name, ``path/to/file.py:function``, or a ``scenes.Case``.
        tolerance: the largest relative bias of the whole image, ``0.005`` or ``"0.5%"``; ``"0.2%,0.5%"``: of
            bounce 0, and of all later ones. Default: the case's.
        tile_tolerance: the same for tiles.
        bounces: the last one, 0 for E alone. Default: the case's.
        size: ``(width, height)`` or ``"64x48"``, in pixels. Default: the case's.
        budget: seconds; less where the verdict is clear sooner. Default: ``--lightproof-budget``, or that of the
            command ``lightproof validate``.
        alpha: probability of a wrong verdict.
        seed: different seeds give independent images.
        unsupported: of a scene that the renderer can't express: ``"skip"`` the test, or let it ``"fail"``.
            Default: ``--lightproof-unsupported``, or to skip.
        report: the folder to write; what a comparison left there before goes. Default: one that is called after
            the test, and stays only if something is wrong, unless ``--lightproof-report`` says where.

    Returns:
        What was found, of verdict ``pass`` or ``known``.

    Raises:
        VerdictError: an ``AssertionError`` with the table of verdicts, and where the report is.
        ValueError, TypeError, UnknownNameError: of an argument that can't be; with what was expected.
        unittest.SkipTest: the scene is unsupported, outside pytest.
    """
    __tracebackhide__ = True
    host = _running_test() or Host()
    try:
        arguments.check_renderer(renderer)
        chosen = arguments.found(case)
        settings = arguments.settings(host, tolerance, tile_tolerance, bounces, size, budget, alpha, seed)
        arguments.check_answer(chosen, settings)
        skips = arguments.skips(unsupported or host.unsupported)
        folder = arguments.prepared(Path(report) if report is not None else host.folder(chosen.name))
    except (ValueError, TypeError, UnknownNameError) as error:
        raise error.with_traceback(None)  # noqa: B904 -- the mistake is the caller's, and shown there
    outcome = compare([chosen], [renderer], settings, folder, Silent())
    host.note(outcome.comparisons[0])
    return _concluded(outcome, folder, host, skips, keeps=report is not None or host.keeps)


def _concluded(outcome: Results, folder: Path, host: Host, skips: bool, keeps: bool) -> Comparison:
    """What agrees is returned, what does not is raised with its report."""
    __tracebackhide__ = True
    [comparison] = outcome.comparisons
    skips = skips and comparison.verdict == "unsupported"
    fine = skips or comparison.verdict in ("pass", "known")
    if fine and not keeps:
        shutil.rmtree(folder, ignore_errors=True)
    else:
        reports.render(folder)
    if not fine:
        page = (folder / reports.REPORT_FILE).resolve()
        raise VerdictError(explanation(outcome, page), comparison, page)
    if skips:
        host.skip(headline(comparison))
    return comparison


def _running_test() -> Host | None:
    """Of pytest, if that is what runs."""
    plugin = sys.modules.get("lightproof.pytest_plugin")
    found: Host | None = plugin.running_test() if plugin else None
    return found
