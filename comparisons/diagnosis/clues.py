"""What speaks for which operator, and how much.

A clue is something that was seen, with weights: roughly the logarithm of how much more likely it is to be seen when
that operator is at fault. Weights of a kind of clue count once, however many cases show it. They were set on one
half of the planted faults (``comparisons.faults``), and are judged on the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from comparisons.diagnosis.patterns import Kind, Pattern, pattern
from comparisons.results import BounceResult, Comparison, Operator, RelationResult

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
    "same factor from 1": {"estimator": 2.5, "E": 0.5},
    "factor by factor": {"R": 4},
    "one bounce": {"series": 3.5},
    "later bounces": {"series": 2, "sampler": 0.5, "R": 0.5},
    "only E": {"E": 4, "sensor": 1},
    "places": {"G": 0.5, "sensor": 1, "R": 0.5},
    "direct": {"R": 0.5, "G": 0.5, "estimator": 0.5, "E": 0.5},
    "irregular": {"G": 0.5, "R": 0.5, "sensor": 0.5},
}

_DARK_IN_SOME: Weights = {"R": 0.5, "G": 0.5, "estimator": 0.5, "E": 0.5}
"""Where other cases have light in these bounces, they are not lost altogether."""

_HINTS: Mapping[str, Weights] = {
    "turned": {"sensor": 5},
    "encoded": {"sensor": 3},
    "exchanged": {"sensor": 3},
    "clipped": {"sensor": 4},
    "shifted": {"sensor": 4},
    "soft": {"sensor": 4},
    "bounces": {"series": 0.5},
    "scaled": {},
}

_MATERIAL: Weights = {"R": 4.0}
_DELTA_LIGHT: Weights = {"E": 4.0}
_ENVIRONMENT: Weights = {"E": 3.5, "G": 0.5}
_SCALED_SHAPE: Weights = {"E": 4.0, "G": 1.5, "estimator": 1.5}  # its area, mostly: what it emits
_ROUND_SHAPE: Weights = {"estimator": 2.5, "G": 2.0}
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
    "sphere": _ROUND_SHAPE,
    "disk": _SCALED_SHAPE,
    "ellipsoid": _SCALED_SHAPE,
    "inward": _ROUND_SHAPE,
    "mesh": {"G": 3.0},
    "shading normals": {"G": 3.0},
    "polar_range": {"E": 2.0, "estimator": 1.0},
    "angular_profile": {"E": 4.0},
    "lights infinitely far": {"E": 4.0, "G": 0.5},
    "lights at a point": {"E": 4.0},
    "metal": {"R": 4.0},
    "glass": {"R": 4.0},
    "an image that is not square": {"sensor": 5.0},
    "things that hide others": {"G": 5.0},
    "an unusual size": {"G": 5.0},
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

_OCCLUDED = _HIDDEN | {
    *(
        "furnace-channels",
        "furnace-bright",
        "furnace-tiny",
        "furnace-huge",
        "furnace-cornell",
        "furnace-mesh",
    ),
    *(
        "furnace-blend",
        "furnace-mirrors",
        "rough-glass-tank",
        "sphere-zones",
        "cornell-box",
        "cie-171-opening",
    ),
}
"""Cases in which something stands between others."""

_SIZED = frozenset(("furnace-tiny", "furnace-huge"))
_SEVERAL = frozenset(("hundred-tiles", "four-points", "sphere-two-caps", "mirror-lamps"))
_FAR = frozenset(("directional", "constant", "environment_map", "spherical_harmonics"))
_DELTA = frozenset(("point", "spot", "directional"))
_SMOOTH = frozenset(("mirror", "conductor", "dielectric"))
_SPECIAL = frozenset(("mirror", "conductor", "dielectric", "rough_conductor", "rough_dielectric", "blend"))


def clues(comparisons: Sequence[Comparison], relations: Sequence[RelationResult]) -> list[Clue]:
    """All that can be seen in the results of one renderer."""
    patterns = [p for p in map(pattern, comparisons) if p is not None]
    return [
        *_of_errors(comparisons),
        *_of_patterns(comparisons, patterns),
        *_of_emission(comparisons, patterns),
        *_of_lights(comparisons),
        *_of_bounces(comparisons),
        *_of_signs(comparisons),
        *_of_shadows(comparisons),
        *_of_features(comparisons),
        *_of_materials(comparisons),
        *_of_smooth_materials(comparisons),
        *_of_hints(comparisons),
        *_of_relations(relations),
    ]


def ignores_its_seed(result: Comparison | RelationResult) -> bool:
    """Whether the probe has found that out; no other error says what is wrong with light."""
    return result.verdict == "error" and "notice of its seed" in result.message


def _of_errors(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    if any(map(ignores_its_seed, comparisons)):
        yield Clue("different seeds give the same image", {"sampler": 8})


def _of_patterns(comparisons: Sequence[Comparison], patterns: Sequence[Pattern]) -> Iterator[Clue]:
    for kind in dict.fromkeys(p.kind for p in patterns):
        seen = [p for p in patterns if p.kind == kind]
        weights = _PATTERNS[kind]
        if kind == "dark from":
            lost = [p for p in seen if not any(_has_light_from(c, p.first) for c in comparisons)]
            seen, weights = (lost, weights) if lost else (seen, _DARK_IN_SOME)
        yield Clue(f"{seen[0].text} ({_some([p.case for p in seen])})", weights)


def _of_emission(comparisons: Sequence[Comparison], patterns: Sequence[Pattern]) -> Iterator[Clue]:
    """Whether bounce 0 is right where something else is wrong: what the sensor does, it does to all bounces."""
    lit = [c for c in comparisons if c.bounces and c.bounces[0].truth_mean > 0]
    wrong = [c for c in lit if c.bounces[0].verdict == "fail"]
    if not wrong:
        if failed := [c.case for c in lit if c.verdict == "fail"]:
            yield Clue(f"E is right wherever it is seen ({_some(failed)})", {"sensor": -2.5, "E": -0.5})
        return
    later = any(b.verdict == "fail" for c in wrong for b in c.bounces[1:])
    whole = [c for c in lit if c not in wrong and any(_mean_fails(b) for b in c.bounces[1:])]
    if whole and not any(h.kinds != ["scaled"] for c in whole for h in c.hints):
        text = f"E is right where later bounces are not ({_some(_names(whole))})"
        yield Clue(text, {"sensor": -6, "E": -1})
    weights: Weights = {
        "E": 1,
        "sensor": 1.5 if later else 0,
        "R": -2,
        "estimator": -2,
        "series": -2,
        "G": 0.5,
    }
    yield Clue(f"E is wrong ({_some([c.case for c in wrong])})", weights)
    same, passed = [p.case for p in patterns if p.kind == "same factor"], _passed(comparisons)
    if same and len(passed) >= 0.2 * len(comparisons):
        yield Clue(f"the factor is not everybody's: {_some(_names(passed))} passed", {"E": 2, "sensor": -1.5})
    elif same and len(comparisons) >= 5:
        yield Clue(f"whatever emits, and whatever reflects, is wrong ({_some(same)})", {"sensor": 2})


def _of_lights(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Which kinds of light go wrong on Lambertian surfaces: next event chooses area lights, and no delta light."""
    plain = [c for c in comparisons if not _SPECIAL & set(c.features)]
    delta = [c for c in plain if _DELTA & set(c.features)]
    area = [c for c in plain if "area" in c.features]
    wrong_delta, wrong_area = ([c for c in some if _indirect_fails(c)] for some in (delta, area))
    if len(delta) < 2 or len(area) < 3 or any(b.verdict == "fail" for c in plain for b in c.bounces[:1]):
        return
    if len(wrong_delta) == len(delta) and wrong_area:
        text = f"light of points and directions, where nothing is chosen, is wrong too ({_some(_names(wrong_delta))})"
        yield Clue(text, {"R": 2, "G": 1, "estimator": -2, "E": -1})
    right_delta = all(c.verdict in ("pass", "known") for c in delta)
    direct = [c for c in wrong_area if _direct_fails(c)]
    if right_delta and len(direct) >= max(3, len(area) / 2):
        text = f"light of lamps with an extent is wrong, that of points and directions right ({_some(_names(delta))})"
        yield Clue(text, {"estimator": 2, "R": -2, "E": 0.5})
    sphere = next((c for c in comparisons if c.case == "furnace-sphere"), None)
    if sphere is not None and wrong_area:
        if sphere.verdict in ("pass", "known"):
            text = "where nothing hides anything, in furnace-sphere, all is right"
            yield Clue(text, {"G": 1.5, "R": -1.5, "series": -0.5})
        elif sphere.verdict == "fail" and len(wrong_delta) == len(delta):
            yield Clue("furnace-sphere, where nothing hides anything, is wrong too", {"R": 1, "G": -1.5})


def _of_bounces(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Direct light right everywhere, later bounces wrong: something that happens on the way."""
    failed = [c for c in comparisons if c.verdict == "fail"]
    direct = [c for c in comparisons if c.verdict == "pass" and len(_lit_indirect(c)) == 1]
    if failed and len(direct) >= 3 and not any(_direct_fails(c) or _e_fails(c) for c in failed):
        text = f"direct light is right in every case ({len(direct)} of them), later bounces are wrong"
        yield Clue(text, {"series": 2.5, "sampler": 1.5, "R": 0.5})


def _of_signs(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Too bright here and too dark there, by the same kinds of light: numbers that are not what they should be."""
    direct = [c.bounces[1] for c in comparisons if c.verdict == "fail" and len(_lit_indirect(c)) == 1]
    wrong = [b for b in direct if _mean_fails(b)]
    bright, dark = ([b for b in wrong if sign * b.bias > 0] for sign in (1, -1))
    kinds = {f for c in comparisons if _direct_fails(c) for f in c.features}
    if len(bright) >= 2 and len(dark) >= 2 and {"area", "constant"} <= kinds:
        text = f"direct light is too bright in {len(bright)} cases and too dark in {len(dark)}, of lamps and skies"
        delta = [c for c in comparisons if _DELTA & set(c.features)]
        nothing_drawn = delta and all(c.verdict in ("pass", "known") for c in delta)
        moved = any(
            b.verdict == "fail" and b.decided_by == "tile" for c in comparisons for b in c.bounces[:1]
        )
        yield Clue(text, {"sampler": 4} if nothing_drawn or moved else {"sampler": 1.5, "R": 1})


def _of_shadows(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Too bright, and only where one thing stands in another's light."""
    failed = [c for c in comparisons if c.verdict == "fail"]
    direct = [c.bounces[1] for c in failed if _direct_fails(c)]
    if direct and all(c.case in _OCCLUDED for c in failed) and all(b.bias > 0 for b in direct):
        text = f"only where one thing stands in another's light it is too bright ({_some(_names(failed))})"
        yield Clue(text, {"G": 4})


def _of_features(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """What all failed scenes have and no other one has."""
    failed = [_all_features(c) for c in comparisons if c.verdict == "fail"]
    passed = [_all_features(c) for c in _passed(comparisons)]
    if not failed or len(passed) < 3:
        return
    common = frozenset.intersection(*failed)
    for feature, weights in _FEATURES.items():
        if feature in common and not any(feature in one for one in passed):
            yield Clue(
                f"only scenes with {feature} fail ({len(failed)} of {len(failed) + len(passed)})", weights
            )


def _of_materials(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Only what is not Lambertian is wrong."""
    failed = [c for c in comparisons if c.verdict == "fail"]
    plain = [c for c in _passed(comparisons) if not _SPECIAL & set(c.features)]
    if failed and len(plain) >= 5 and all(_SPECIAL & set(c.features) for c in failed):
        text = f"what is only Lambertian is right in all {len(plain)} cases"
        yield Clue(text, {"R": 2, "estimator": 0.5})


def _of_smooth_materials(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Several materials that have a single direction in common, which no other strategy finds."""
    failed = [set(c.features) for c in comparisons if _indirect_fails(c)]
    kinds = {kind for features in failed for kind in _SMOOTH & features}
    if len(kinds) >= 2 and all(_SMOOTH & features for features in failed):
        text = f"{', '.join(sorted(kinds))} fail alike, all of which reflect into single directions"
        yield Clue(text, {"estimator": 3.5, "G": 0.5, "R": 0.5})


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


# ---- what comparisons are like


def _passed(comparisons: Sequence[Comparison]) -> list[Comparison]:
    return [c for c in comparisons if c.verdict in ("pass", "known")]


def _has_light_from(comparison: Comparison, first: int) -> bool:
    return any(b.mean > 0.5 * b.truth_mean > 0 for b in comparison.bounces if b.bounce >= first)


def _lit_indirect(comparison: Comparison) -> list[int]:
    return [b.bounce for b in comparison.bounces if b.bounce > 0 and b.truth_mean > 0]


def _indirect_fails(comparison: Comparison) -> bool:
    return any(b.verdict == "fail" for b in comparison.bounces[1:])


def _direct_fails(comparison: Comparison) -> bool:
    return any(b.verdict == "fail" for b in comparison.bounces[1:2])


def _e_fails(comparison: Comparison) -> bool:
    return any(b.verdict == "fail" for b in comparison.bounces[:1])


def _mean_fails(bounce: BounceResult) -> bool:
    return bounce.verdict == "fail" and bounce.decided_by == "image"


def _all_features(comparison: Comparison) -> frozenset[str]:
    features = frozenset(comparison.features)
    more = {
        "lights infinitely far": bool(_FAR & features),
        "lights at a point": bool({"point", "spot"} & features),
        "metal": bool({"conductor", "rough_conductor"} & features),
        "glass": bool({"dielectric", "rough_dielectric"} & features),
        "an image that is not square": comparison.width != comparison.height,
        "things that hide others": comparison.case in _HIDDEN,
        "an unusual size": comparison.case in _SIZED,
        "several emitters": comparison.case in _SEVERAL,
    }
    return features | {name for name, has in more.items() if has}


def _names(comparisons: Sequence[Comparison]) -> list[str]:
    return [c.case for c in comparisons]


def _some(names: Sequence[str]) -> str:
    """The first of them, and how many more."""
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
