"""What comparisons are like, in the words that clues are made of."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from comparisons.diagnosis import tables
from comparisons.results import BounceResult, Comparison
from scenes import library


def passed(comparisons: Sequence[Comparison]) -> list[Comparison]:
    """Those that did."""
    return [c for c in comparisons if c.verdict in ("pass", "known")]


def has_light_from(comparison: Comparison, first: int) -> bool:
    """Whether some bounce from this one on has most of its light."""
    return any(b.mean > 0.5 * b.truth_mean > 0 for b in comparison.bounces if b.bounce >= first)


def lit_indirect(comparison: Comparison) -> list[int]:
    """Bounces beyond E that should have light."""
    return [b.bounce for b in comparison.bounces if b.bounce > 0 and b.truth_mean > 0]


def lit_materials(comparison: Comparison) -> set[tuple[str, str]]:
    """Each of its lights with each of its materials."""
    features = set(comparison.features)
    return {
        (light, material) for light in tables.LIGHTS & features for material in tables.MATERIALS & features
    }


def indirect_fails(comparison: Comparison) -> bool:
    """Whether a bounce beyond E does."""
    return any(b.verdict == "fail" for b in comparison.bounces[1:])


def direct_fails(comparison: Comparison) -> bool:
    """Whether TE does."""
    return any(b.verdict == "fail" for b in comparison.bounces[1:2])


def e_fails(comparison: Comparison) -> bool:
    """Whether E does."""
    return any(b.verdict == "fail" for b in comparison.bounces[:1])


@cache
def _emitters(name: str) -> int:
    """How many there are in a scene of the library; 0 of one that is not in it."""
    if name not in library.CASES:
        return 0
    scene = library.case(name).scene
    return sum(surface.emits for surface in scene.surfaces) + len(scene.lights)


def mean_fails(bounce: BounceResult) -> bool:
    """Whether it fails over the whole image."""
    return bounce.verdict == "fail" and bounce.decided_by == "image"


def all_features(comparison: Comparison) -> frozenset[str]:
    """Those of its scene, and kinds of them."""
    features = frozenset(comparison.features)
    more = {kind: bool(members & features) for kind, members in tables.OF_A_KIND.items()} | {
        "an image that is not square": comparison.width != comparison.height,
        "things that hide others": comparison.case in tables.HIDDEN,
        "an unusual size": comparison.case in tables.SIZED,
        "several emitters": _emitters(comparison.case) > 1,
    }
    return features | {name for name, has in more.items() if has}


def names(comparisons: Sequence[Comparison]) -> list[str]:
    """Of their cases."""
    return [c.case for c in comparisons]


def some(names: Sequence[str]) -> str:
    """The first of them, and how many more."""
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def only_lamps(comparisons: Sequence[Comparison]) -> bool:
    """Whether all that fails is lit by lamps with an extent, and several things that are not pass."""
    failed = [c for c in comparisons if c.verdict == "fail"]
    return all("area" in c.features for c in failed) and len(not_lit_by_lamps(comparisons)) >= 2


def not_lit_by_lamps(comparisons: Sequence[Comparison]) -> list[Comparison]:
    """Those that passed without any lamp of an extent."""
    return [c for c in passed(comparisons) if "area" not in c.features]


def only_where_hidden(comparisons: Sequence[Comparison]) -> bool:
    """Whether only such cases fail in which one thing hides another, and not beside one that is just about that.

    Unless what hides has another shape in all that fail: round things, say, where flat ones cast their shadows.
    """
    failed = [c for c in comparisons if c.verdict == "fail"]
    right = [c for c in passed(comparisons) if c.case in tables.HIDDEN]
    shapes = tables.SHAPES.intersection(*(c.features for c in failed)).difference(
        *(c.features for c in right)
    )
    if all(tables.SPECIAL & set(c.features) for c in failed):
        return False  # what they are made of is as likely
    about_it = any(c.case in tables.HIDDEN for c in failed) or not right or bool(shapes)
    return about_it and tables.OCCLUDED.issuperset(names(failed))


def begins_late(failed: Sequence[Comparison]) -> bool:
    """Whether direct light is right wherever it is seen."""
    direct = [b for c in failed for b in c.bounces[1:2] if b.truth_mean > 0]
    return bool(direct) and not any(b.verdict == "fail" for b in direct)
