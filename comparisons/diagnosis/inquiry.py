"""What a renderer is asked once a case has failed: the same case again, in ways that tell operators apart.

first hits     what camera rays meet, where the case failed: G by itself
scaling        the scene larger and smaller: an offset or an end of rays that is a length shows, and nothing else
other ways     light by chance alone, by next event alone, with other random numbers: ``ways``
"""

from __future__ import annotations

from collections.abc import Sequence

from comparisons import campaign, relations
from comparisons.relations import CHEAP_WALKS, Subject, Task
from comparisons.renderers import Renderer
from comparisons.results import Comparison, RelationResult
from comparisons.settings import Settings, Silent
from scenes import Case, Scene

RELATIONS = ("first-hits", "scaling", "partial-sums")

CASES, BUDGET = 2, 2.0
"""How many of the cases that failed are asked about, and seconds for each question."""

MOST_BOUNCES, PIXELS = 3, 24
"""Of what relations look at, and along its smaller side: what rays miss they miss early, and much of it."""


def inquire(
    case: Case,
    asked: Sequence[str],
    renderer: str | Renderer,
    ways: Sequence[str | Renderer],
    settings: Settings,
) -> tuple[list[RelationResult], list[Comparison]]:
    """What these relations find in the case, and what the other ways make of it.

    Args:
        case: that failed.
        asked: names of relations, ``RELATIONS`` here or some of them.
        renderer: of which it failed.
        ways: its other ways to look for light, called as in ``ways.WAYS``.
        settings: of each question.
    """
    subject = Subject(case.name, _small(case.scene), min(case.bounces, MOST_BOUNCES), case.wavelengths)
    tasks = [Task(relations.RELATIONS[name], subject, walks=CHEAP_WALKS) for name in asked]
    answers = list(relations.run(tasks, [renderer], settings, Silent()))
    others = campaign.run([case], ways, settings, None, Silent()) if ways else ()
    return answers, list(others)


def _small(scene: Scene) -> Scene:
    height, width, _ = scene.shape
    shrink = max(1.0, min(height, width) / PIXELS)
    return scene.resized(round(width / shrink), round(height / shrink)) if shrink > 1 else scene
