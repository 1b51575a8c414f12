"""What speaks for which operator, and how much.

A clue is something that was seen, with weights: roughly the logarithm of how much more likely it is to be seen when
that operator is at fault. Weights of a kind of clue count once, however many cases show it. They were set on one
half of the planted faults (``comparisons.faults``), and are judged on the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from comparisons.diagnosis.patterns import Kind, Pattern, pattern
from comparisons.results import Comparison, Operator, RelationResult

Weights = Mapping[Operator, float]


@dataclass(frozen=True)
class Clue:
    """Something that was seen: as a sentence, and what it speaks for."""

    text: str
    weights: Weights


_PATTERNS: Mapping[Kind, Weights] = {
    "error": {},
    "none of E": {"E": 5},
    "dark from": {"series": 4},
    "light after the last": {"series": 4},
    "counted from another number": {"series": 6},
    "same factor": {"E": 2, "sensor": 2},
    "same factor from 1": {"estimator": 3, "E": 1},
    "factor by factor": {"R": 4},
    "one bounce": {"series": 3.5},
    "later bounces": {"series": 2.5, "sampler": 1, "R": 1},
    "only E": {"E": 4, "sensor": 1},
    "places": {"G": 1, "sensor": 1.5, "R": 0.5},
    "direct": {"R": 0.5, "G": 0.5, "estimator": 0.5, "E": 0.5},
    "irregular": {"G": 0.5, "R": 0.5, "sensor": 0.5},
}

_HINTS: Mapping[str, Weights] = {
    "turned": {"sensor": 5},
    "encoded": {"sensor": 3},
    "exchanged": {"sensor": 3},
    "clipped": {"sensor": 4},
    "shifted": {"sensor": 4},
    "soft": {"sensor": 4},
    "bounces": {"series": 2},
    "scaled": {},
}

_MATERIAL: Weights = {"R": 4.0}
_DELTA_LIGHT: Weights = {"E": 4.0}
_ENVIRONMENT: Weights = {"E": 3.0, "G": 1.0}
_SHAPE: Weights = {"G": 2.0, "estimator": 2.0, "E": 1.0}
_FEATURES: Mapping[str, Weights] = {
    "mirror": _MATERIAL,
    "conductor": _MATERIAL,
    "dielectric": _MATERIAL,
    "rough_conductor": _MATERIAL,
    "rough_dielectric": _MATERIAL,
    "blend": _MATERIAL,
    "point": _DELTA_LIGHT,
    "spot": _DELTA_LIGHT,
    "directional": _DELTA_LIGHT,
    "constant": _ENVIRONMENT,
    "environment_map": _ENVIRONMENT,
    "spherical_harmonics": _ENVIRONMENT,
    "sphere": _SHAPE,
    "disk": _SHAPE,
    "ellipsoid": _SHAPE,
    "inward": _SHAPE,
    "mesh": {"G": 3.0},
    "shading normals": {"G": 3.0},
    "polar_range": {"E": 2.0, "estimator": 1.0},
    "angular_profile": {"E": 4.0},
    "hidden": {"G": 5.0},
    "small": {"G": 5.0},
    "several emitters": {"estimator": 3.0},
}

_FIRST_HITS: Weights = {"G": 4.0}
_RELATIONS: Mapping[str, Weights] = {
    "E": {"E": 2.0},
    "G": {"G": 2.0},
    "R": {"R": 2.0},
    "sensor": {"sensor": 2.0},
    "estimator": {"estimator": 2.0},
}

_HIDDEN = frozenset(
    (
        "screened-lamp",
        "disk-shadow",
        "lamp-over-a-wall",
        "block-over-plane",
        "wall-behind-a-shelf",
        "around-the-corner",
    )
)
"""Cases about one thing that hides another."""

_SMALL = frozenset(("furnace-tiny", "furnace-huge"))
_SEVERAL = frozenset(("hundred-tiles", "four-points", "sphere-two-caps", "mirror-lamps"))


def clues(comparisons: Sequence[Comparison], relations: Sequence[RelationResult]) -> list[Clue]:
    """All that can be seen in the results of one renderer."""
    patterns = [p for p in map(pattern, comparisons) if p is not None]
    return [
        *_of_errors(comparisons),
        *_of_patterns(patterns),
        *_of_emission(comparisons),
        *_of_features(comparisons),
        *_of_hints(comparisons),
        *_of_relations(relations),
    ]


def ignores_its_seed(result: Comparison | RelationResult) -> bool:
    """Whether the probe has found that out; no other error says what is wrong with light."""
    return result.verdict == "error" and "notice of its seed" in result.message


def _of_errors(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    if any(map(ignores_its_seed, comparisons)):
        yield Clue("different seeds give the same image", {"sampler": 8})


def _of_patterns(patterns: Sequence[Pattern]) -> Iterator[Clue]:
    kinds = dict.fromkeys(p.kind for p in patterns)
    for kind in kinds:
        seen = [p for p in patterns if p.kind == kind]
        where = ", ".join(p.case for p in seen[:3]) + (f" and {len(seen) - 3} more" if len(seen) > 3 else "")
        yield Clue(f"{seen[0].text} ({where})", _PATTERNS[kind])


def _of_emission(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Whether bounce 0 is right where something else is wrong: what the sensor does, it does to all bounces."""
    failed = [c for c in comparisons if c.verdict == "fail"]
    lit = [c for c in failed if c.bounces and c.bounces[0].truth_mean > 0]
    wrong = [c for c in lit if c.bounces[0].verdict == "fail"]
    if lit and not wrong:
        yield Clue(f"E is right wherever it is seen ({len(lit)} cases)", {"sensor": -2, "E": -0.5})
    if wrong:
        later = [c for c in wrong if any(b.verdict == "fail" for b in c.bounces[1:])]
        text = f"E is wrong ({', '.join(c.case for c in wrong[:3])})"
        yield Clue(
            text, {"E": 1, "sensor": 2 if later else 0, "R": -2, "estimator": -2, "series": -2, "G": 0.5}
        )


def _of_features(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """What all failed scenes have and no other one has."""
    failed = [_all_features(c) for c in comparisons if c.verdict == "fail"]
    passed = [_all_features(c) for c in comparisons if c.verdict in ("pass", "known")]
    if not failed or len(passed) < 3:
        return
    common = frozenset.intersection(*failed)
    for feature, weights in _FEATURES.items():
        if feature in common and not any(feature in one for one in passed):
            yield Clue(
                f"only scenes with {feature} fail ({len(failed)} of {len(failed) + len(passed)})", weights
            )
    if len(failed) > 3 and not passed:
        yield Clue("everything fails", {"R": 1, "sensor": 1})


def _all_features(comparison: Comparison) -> frozenset[str]:
    more = {
        "hidden": comparison.case in _HIDDEN,
        "small": comparison.case in _SMALL,
        "several emitters": comparison.case in _SEVERAL,
    }
    return frozenset(comparison.features) | {name for name, has in more.items() if has}


def _of_hints(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    seen: dict[str, tuple[str, str]] = {}
    for comparison in comparisons:
        for hint in comparison.hints:
            for kind in hint.kinds:
                seen.setdefault(kind, (hint.text, comparison.case))
    for kind, (text, name) in seen.items():
        if _HINTS[kind]:
            yield Clue(f"{name}: {text[0].lower()}{text[1:].rstrip('.')}", _HINTS[kind])


def _of_relations(relations: Sequence[RelationResult]) -> Iterator[Clue]:
    for result in relations:
        if result.verdict == "fail" and result.operator in _RELATIONS:
            text = f"{result.relation} ({result.scene}): {result.message or result.statement}"
            # closed forms tell more than one image does of another
            yield Clue(text, _FIRST_HITS if result.relation == "first-hits" else _RELATIONS[result.operator])
