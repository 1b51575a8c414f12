"""Relations: checks that need no second renderer and no truth. One per file, or a close group; and this list."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from comparisons.relations.channels import CHANNELS
from comparisons.relations.first_hits import FIRST_HITS
from comparisons.relations.homogeneity import HOMOGENEITY
from comparisons.relations.linearity import LINEARITY
from comparisons.relations.partial_sums import PARTIAL_SUMS
from comparisons.relations.reciprocity import RECIPROCITY
from comparisons.relations.relation import Relation
from comparisons.relations.runner import DEFAULT_BOUNCES, Subject, Task, run
from comparisons.relations.samples import SEEDS, SPP
from comparisons.relations.similarities import MIRRORING, ROLL, ROTATION, SCALING
from comparisons.relations.stages import STAGES
from comparisons.relations.strategies import STRATEGIES
from comparisons.relations.superposition import SUPERPOSITION
from scenes import Tolerance

__all__ = [
    "CHEAP_BUDGET",
    "CHEAP_WALKS",
    "DEFAULT_BOUNCES",
    "RELATIONS",
    "STAGES",
    "Relation",
    "Subject",
    "Task",
    "all_tasks",
    "cheap_tasks",
    "run",
]

RELATIONS: Mapping[str, Relation] = MappingProxyType(
    {
        relation.name: relation
        for relation in (
            FIRST_HITS,
            SUPERPOSITION,
            LINEARITY,
            HOMOGENEITY,
            PARTIAL_SUMS,
            RECIPROCITY,
            ROTATION,
            MIRRORING,
            ROLL,
            SCALING,
            CHANNELS,
            SPP,
            SEEDS,
            STRATEGIES,
        )
    }
)
"""From G to the estimator."""

CHEAP_BUDGET, CHEAP_BOUNCES, CHEAP_WALKS = 20.0, 2, 2048
CHEAP_TOLERANCE = Tolerance(image=(0.10, 0.05, 0.10), tile=(0.50, 0.25, 0.50))
"""In a run that is about something else: half a second each on an idle machine, for faults that are gross."""


def all_tasks(relations: Sequence[Relation], subjects: Sequence[Subject] = ()) -> list[Task]:
    """Each relation on each of these scenes; without scenes, on those that are made for it."""
    return [
        Task(relation, subject)
        for relation in relations
        for subject in subjects or [Subject(name, STAGES[name]()) for name in relation.scenes]
    ]


def cheap_tasks() -> list[Task]:
    """What a default run has besides its comparisons: each cheap relation on its first scene."""
    return [
        Task(
            relation,
            Subject(name := relation.scenes[0], STAGES[name](), CHEAP_BOUNCES),
            CHEAP_BUDGET,
            CHEAP_TOLERANCE,
            CHEAP_WALKS,
        )
        for relation in RELATIONS.values()
        if relation.cheap
    ]
