"""What a renderer is asked once a case has failed: the same case again, in ways that tell operators apart.

other ways     light by chance alone, by next event alone, with other random numbers: ``ways``
first hits     what camera rays meet, where the case failed: G by itself
scaling        the scene larger and smaller: an offset or an end of rays that is a length shows, and nothing else
partial sums   where E or only a late bounce is wrong: bounces that are asked for alone and together
roll           where E or the place of light is wrong: the camera upside down, which only the sensor can tell
spp            where the other ways are wrong by something else: few samples and many, which light does not know of

A question is asked only where its answer may tell something, as each takes as long as a case does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from comparisons import campaign, relations
from comparisons.diagnosis.ways import heard
from comparisons.relations import CHEAP_WALKS, Subject, Task
from comparisons.renderers import Renderer
from comparisons.results import Comparison, RelationResult
from comparisons.settings import Settings, Silent
from scenes import Case, Scene

CASES, BUDGET = 2, 2.0
"""How many of the cases that failed are asked about, and seconds for each question."""

UNSTEADY = 0.01
"""Standard error of a bounce that failed, from which on its replicates are not of one kind."""

MOST_BOUNCES, PIXELS = 3, 24
"""Of what relations look at, and along its smaller side: what rays miss they miss early, and much of it."""


def inquire(
    case: Case,
    failed: Comparison,
    renderer: str | Renderer,
    ways: Sequence[str | Renderer],
    settings: Settings,
    thoroughly: bool = True,
) -> tuple[list[RelationResult], list[Comparison]]:
    """What these relations find in the case, and what the other ways make of it.

    Args:
        case: that failed.
        failed: the result that says so.
        renderer: of which it failed.
        ways: its other ways to look for light, called as in ``ways.WAYS``.
        settings: of each question.
        thoroughly: if not, only first hits and the other ways.
    """
    others = list(campaign.run([case], ways, settings, None, Silent())) if ways else []
    subject = Subject(case.name, _small(case.scene), min(case.bounces, MOST_BOUNCES), case.wavelengths)
    asked = questions(failed, others) if thoroughly else ["first-hits"]
    tasks = [Task(relations.RELATIONS[name], subject, walks=CHEAP_WALKS) for name in asked]
    return list(relations.run(tasks, [renderer], settings, Silent())), others


def questions(failed: Comparison, others: Sequence[Comparison]) -> Iterator[str]:
    """The relations that may tell something of it, by their names."""
    yield from ("first-hits", "scaling")
    wrong = [b for b in failed.bounces if b.verdict == "fail"]
    later = [b for b in failed.bounces[1:] if b.truth_mean > 0 or b.verdict == "fail"]
    only_late = bool(later) and later[-1].verdict == "fail" != later[0].verdict
    # replicates that differ by far more than noise may have been asked for other bounces
    if only_late or any(b.bounce == 0 or b.standard_error > UNSTEADY for b in wrong):
        yield "partial-sums"
    if any(b.bounce == 0 or b.decided_by == "tile" for b in wrong):
        yield "roll"
    unlike = any(way.unlike for way in heard([failed], others).values())
    if not others or unlike:
        yield "spp"


def _small(scene: Scene) -> Scene:
    height, width, _ = scene.shape
    shrink = max(1.0, min(height, width) / PIXELS)
    return scene.resized(round(width / shrink), round(height / shrink)) if shrink > 1 else scene
