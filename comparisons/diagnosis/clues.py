"""What speaks for which operator, and how much.

A clue is something that was seen, with weights: roughly the logarithm of how much more likely it is to be seen when
that operator is at fault (``tables``, and beside the clues). Weights of a kind of clue count once, however many cases
show it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from msgspec.structs import replace

from comparisons.diagnosis import tables
from comparisons.diagnosis.clue import Clue, Weights
from comparisons.diagnosis.patterns import Pattern, pattern
from comparisons.diagnosis.views import (
    all_features,
    begins_late,
    direct_fails,
    e_fails,
    has_light_from,
    indirect_fails,
    lit_indirect,
    lit_materials,
    mean_fails,
    names,
    not_lit_by_lamps,
    only_lamps,
    only_where_hidden,
    passed,
    some,
)
from comparisons.diagnosis.ways import Heard, Way, clues_of_ways, heard
from comparisons.results import Comparison, RelationResult
from comparisons.verdict import overall


def clues(
    comparisons: Sequence[Comparison],
    relations: Sequence[RelationResult],
    others: Sequence[Comparison] = (),
) -> list[Clue]:
    """All that can be seen in the results of one renderer."""
    totals = list(_of_totals(comparisons))
    comparisons = [_by_bounce(c) for c in comparisons]
    patterns = [p for p in map(pattern, comparisons) if p is not None]
    return [
        *totals,
        *_of_errors(comparisons),
        *_of_patterns(comparisons, patterns),
        *_of_emission(comparisons, patterns),
        *_of_all(comparisons),
        *_of_lights(comparisons),
        *_of_bounces(comparisons),
        *_of_signs(comparisons),
        *_of_shadows(comparisons),
        *_of_features(comparisons),
        *_of_materials(comparisons),
        *_of_what_is_right_elsewhere(comparisons),
        *_of_smooth_materials(comparisons),
        *_of_hints(comparisons),
        *_of_relations(comparisons, relations, heard(comparisons, others)),
        *clues_of_ways(comparisons, others),
    ]


def ignores_its_seed(result: Comparison | RelationResult) -> bool:
    """Whether the probe has found that out; no other error says what is wrong with light."""
    return result.verdict == "error" and "notice of its seed" in result.message


def _of_errors(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    if any(map(ignores_its_seed, comparisons)):
        yield Clue("different seeds give the same image", {"sampler": 8})


def _of_totals(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Every bounce right, and their sum wrong: something that only the renderer's own defaults do."""
    wrong = [c for c in comparisons if [t.verdict for t in c.totals] == ["fail"]]
    alone = [c for c in wrong if c.bounces and not any(b.verdict == "fail" for b in c.bounces)]
    if alone and len(alone) == len(wrong):
        text = (
            "each bounce is right by itself, and the total is not, which is rendered with the renderer's own "
            f"defaults: Russian roulette, a last bounce, a clamp ({some(names(alone))})"
        )
        yield Clue(text, tables.TOTAL)


def _by_bounce(comparison: Comparison) -> Comparison:
    """As its bounces alone are: what is told of the others is about them."""
    if not comparison.bounces or comparison.verdict != "fail":
        return comparison
    return replace(comparison, verdict=overall(b.verdict for b in comparison.bounces))


def _of_patterns(comparisons: Sequence[Comparison], patterns: Sequence[Pattern]) -> Iterator[Clue]:
    for kind in dict.fromkeys(p.kind for p in patterns):
        seen = [p for p in patterns if p.kind == kind]
        weights = tables.PATTERNS[kind]
        if kind == "none of E" and any(p.kind == "counted from another number" for p in patterns):
            continue  # it is in another bounce
        if kind == "counted from another number" and _all_by_one_factor(patterns):
            continue  # a furnace where every bounce is half of the one before
        if kind == "dark from":
            lost = [p for p in seen if not any(has_light_from(c, p.first) for c in comparisons)]
            seen, weights = (lost, weights) if lost else (seen, tables.DARK_IN_SOME)
        yield Clue(f"{seen[0].text} ({some([p.case for p in seen])})", weights)


def _all_by_one_factor(patterns: Sequence[Pattern]) -> bool:
    """Whether more cases are off by one factor in all bounces than have them counted from another number."""
    kinds = [p.kind for p in patterns]
    return kinds.count("same factor") > kinds.count("counted from another number")


def _of_emission(comparisons: Sequence[Comparison], patterns: Sequence[Pattern]) -> Iterator[Clue]:
    """Whether bounce 0 is right where something else is wrong: what the sensor does, it does to all bounces."""
    lit = [c for c in comparisons if c.bounces and c.bounces[0].truth_mean > 0]
    wrong = [c for c in lit if c.bounces[0].verdict == "fail"]
    if not wrong:
        if failed := [c.case for c in lit if c.verdict == "fail"]:
            yield Clue(f"E is right wherever it is seen ({some(failed)})", {"sensor": -2.5, "E": -0.5})
        return
    later = any(b.verdict == "fail" for c in wrong for b in c.bounces[1:])
    whole = [c for c in lit if c not in wrong and any(mean_fails(b) for b in c.bounces[1:])]
    if whole and not any(h.kinds != ["scaled"] for c in comparisons for h in c.hints):
        text = f"E is right where later bounces are not ({some(names(whole))})"
        yield Clue(text, {"sensor": -3, "E": -1})
    if only_lamps(comparisons):
        text = (
            f"what lamps with an extent don't light is right ({some(names(not_lit_by_lamps(comparisons)))})"
        )
        yield Clue(text, {"E": 1.5, "sensor": -3})
    weights: Weights = {
        "E": 1,
        "sensor": 1.5 if later else 0.5,
        "R": -2,
        "estimator": -2,
        "series": -0.5,
        "G": 0.5,
    }
    yield Clue(f"E is wrong ({some([c.case for c in wrong])})", weights)
    same, right = [p.case for p in patterns if p.kind == "same factor"], passed(comparisons)
    if same and len(right) >= 0.2 * len(comparisons):
        yield Clue(f"the factor is not everybody's: {some(names(right))} passed", {"E": 2, "sensor": -1.5})
    elif same and len(comparisons) >= 5:
        yield Clue(f"whatever emits, and whatever reflects, is wrong ({some(same)})", {"sensor": 2})


def _of_all(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Everything is wrong, whatever shines and whatever reflects: what all have in common is the image."""
    failed, right = [c for c in comparisons if c.verdict == "fail"], passed(comparisons)
    kinds = {f for c in failed for f in c.features}
    reflects = [c for c in failed if "lambertian" not in c.features]
    shines = [kind for kind in (tables.DELTA, {"area"}, tables.FAR) if kind & kinds]
    if len(failed) >= 6 and len(right) <= len(failed) / 10 and reflects and len(shines) >= 2:
        yield Clue(
            f"all but {len(right)} of {len(failed) + len(right)} cases fail, whatever they are of",
            {"sensor": 4},
        )


def _of_lights(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Which kinds of light go wrong on Lambertian surfaces: next event chooses area lights, and no delta light."""
    plain = [c for c in comparisons if not tables.SPECIAL & set(c.features)]
    delta = [c for c in plain if tables.DELTA & set(c.features)]
    area = [c for c in plain if "area" in c.features]
    wrong_delta, wrong_area = ([c for c in kind if indirect_fails(c)] for kind in (delta, area))
    if len(delta) < 2 or len(area) < 3 or any(b.verdict == "fail" for c in plain for b in c.bounces[:1]):
        return
    if len(wrong_delta) == len(delta) and wrong_area:
        text = f"light of points and directions, where nothing is chosen, is wrong too ({some(names(wrong_delta))})"
        yield Clue(text, {"R": 2, "G": 1, "estimator": -2, "E": -1})
    right_delta = all(c.verdict in ("pass", "known") for c in delta)
    direct = [c for c in wrong_area if direct_fails(c)]
    if right_delta and len(direct) >= max(3, len(area) / 2):
        text = f"light of lamps with an extent is wrong, that of points and directions right ({some(names(delta))})"
        yield Clue(text, {"estimator": 2, "R": -2, "E": 0.5})
    failed = {f for c in comparisons if c.verdict == "fail" for f in c.features}
    if failed and not failed & tables.DRAWN:
        yield Clue("only light of points and directions is wrong, where nothing is drawn", {"estimator": -3})
    sphere = next((c for c in comparisons if c.case == "furnace-sphere"), None)
    if sphere is not None and wrong_area:
        if sphere.verdict in ("pass", "known") and only_where_hidden(comparisons):
            text = "where nothing hides anything, in furnace-sphere, all is right"
            yield Clue(text, {"G": 1.5, "R": -1.5, "series": -0.5})
        elif sphere.verdict == "fail" and len(wrong_delta) == len(delta):
            yield Clue("furnace-sphere, where nothing hides anything, is wrong too", {"R": 1, "G": -1.5})


def _of_bounces(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Direct light right everywhere, later bounces wrong: something that happens on the way."""
    failed = [c for c in comparisons if c.verdict == "fail"]
    direct = [c for c in comparisons if c.verdict == "pass" and len(lit_indirect(c)) == 1]
    if failed and len(direct) >= 3 and not any(direct_fails(c) or e_fails(c) for c in failed):
        text = f"direct light is right in every case ({len(direct)} of them), later bounces are wrong"
        yield Clue(text, {"series": 2.5, "sampler": 1.5, "R": 0.5})


def _of_signs(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Too bright here and too dark there, by the same kinds of light: numbers that are not what they should be."""
    direct = [c.bounces[1] for c in comparisons if c.verdict == "fail" and len(lit_indirect(c)) == 1]
    wrong = [b for b in direct if mean_fails(b)]
    bright, dark = ([b for b in wrong if sign * b.bias > 0] for sign in (1, -1))
    kinds = {f for c in comparisons if direct_fails(c) for f in c.features}
    if len(bright) >= 2 and len(dark) >= 2 and {"area", "constant"} <= kinds:
        text = f"direct light is too bright in {len(bright)} cases and too dark in {len(dark)}, of lamps and skies"
        delta = [c for c in comparisons if tables.DELTA & set(c.features)]
        nothing_drawn = delta and all(c.verdict in ("pass", "known") for c in delta)
        moved = any(
            b.verdict == "fail" and b.decided_by == "tile" for c in comparisons for b in c.bounces[:1]
        )
        yield Clue(text, {"sampler": 4} if nothing_drawn or moved else {"sampler": 1.5, "R": 1})


def _of_shadows(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Too bright, and only where one thing stands in another's light."""
    failed = [c for c in comparisons if c.verdict == "fail"]
    direct = [c.bounces[1] for c in failed if direct_fails(c)]
    if direct and only_where_hidden(comparisons) and all(b.bias > 0 for b in direct):
        text = f"only where one thing stands in another's light it is too bright ({some(names(failed))})"
        yield Clue(text, {"G": 4})


def _of_features(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """What all failed scenes have and no other one has."""
    wrong = [c for c in comparisons if c.verdict == "fail"]
    failed = [all_features(c) for c in wrong]
    right = [all_features(c) for c in passed(comparisons)]
    if not failed or len(right) < 3:
        return
    common = frozenset.intersection(*failed)
    # where direct light is right, whatever emits and whatever is sampled is
    late = begins_late(wrong)
    special = all(tables.SPECIAL & one - frozenset[str]().union(*right) for one in failed)
    said = set[str]()
    for feature, weights in tables.FEATURES.items():
        if late and not weights.keys() & {"R", "sensor"}:
            continue
        if special and "E" in weights:  # what they are made of is as likely
            weights = {operator: weight / 2 for operator, weight in weights.items()}
        if said & tables.OF_A_KIND.get(feature, set()):
            continue  # the one that is of this kind is said already
        if feature in common and not any(feature in one for one in right):
            said.add(feature)
            yield Clue(
                f"only scenes with {feature} fail ({len(failed)} of {len(failed) + len(right)})", weights
            )


def _of_materials(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Only what is not Lambertian is wrong."""
    failed = [c for c in comparisons if c.verdict == "fail"]
    plain = [c for c in passed(comparisons) if not tables.SPECIAL & set(c.features)]
    if failed and len(plain) >= 5 and all(tables.SPECIAL & set(c.features) for c in failed):
        text = f"what is only Lambertian is right in all {len(plain)} cases"
        yield Clue(text, {"R": 2, "estimator": 0.5})


def _of_what_is_right_elsewhere(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Each light on each material that fails is right in another case: what is left is where they stand."""
    wrong = {pair for c in comparisons if c.verdict == "fail" for pair in lit_materials(c)}
    right = passed(comparisons)
    if len(right) >= 5 and wrong and wrong.issubset(pair for c in right for pair in lit_materials(c)):
        text = f"the same lights on the same materials are right in other cases ({len(right)} passed)"
        yield Clue(text, tables.RIGHT_ELSEWHERE)


def _of_smooth_materials(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    """Several materials that have a single direction in common, which no other strategy finds."""
    failed = [set(c.features) for c in comparisons if indirect_fails(c)]
    kinds = {kind for features in failed for kind in tables.SMOOTH & features}
    if len(kinds) >= 2 and all(tables.SMOOTH & features for features in failed):
        text = f"{', '.join(sorted(kinds))} fail alike, all of which reflect into single directions"
        yield Clue(text, {"estimator": 3.5, "G": 0.5, "R": 0.5})


def _of_hints(comparisons: Sequence[Comparison]) -> Iterator[Clue]:
    seen: dict[str, tuple[str, str]] = {}
    only_textures = all("image texture" in c.features for c in comparisons if c.verdict == "fail")
    for comparison in comparisons:
        for hint in comparison.hints:
            for kind in hint.kinds:
                seen.setdefault(kind, (hint.text, comparison.case))
    for kind, (text, name) in seen.items():
        if tables.HINTS[kind]:
            # a sensor does to all images what it does to one, though not every one has edges, or is bright
            most_right = len(passed(comparisons)) > 0.8 * len(comparisons)
            rare = (most_right and kind not in ("clipped", "soft", "shifted")) or only_textures
            weights = {o: w / 2 if rare else w for o, w in tables.HINTS[kind].items()}
            yield Clue(f"{name}: {text[0].lower()}{text[1:].rstrip('.')}", weights)


def _of_relations(
    comparisons: Sequence[Comparison], relations: Sequence[RelationResult], ways: Mapping[Way, Heard]
) -> Iterator[Clue]:
    # a length that matters is G's, unless light that is found is right, or all that fails falls off from a point
    found_right = "chance" in ways and bool(ways["chance"].right)
    failed = [set(c.features) for c in comparisons if c.verdict == "fail"]
    lamps = found_right or (bool(failed) and not any(tables.DRAWN & features for features in failed))
    told = {
        "first-hits": tables.FIRST_HITS,
        "scaling": tables.SCALING_OF_LAMPS if lamps else tables.SCALING,
        "partial-sums": tables.PARTIAL_SUMS,
        "spp": tables.SPP,
        "roll": tables.ROLL,
    }
    said = set[str]()
    for result in relations:
        if result.verdict == "fail" and result.relation not in said:
            said.add(result.relation)
            weights = told.get(result.relation) or tables.RELATIONS.get(result.operator, {})
            if result.relation == "first-hits" and result.operator == "sensor":
                weights = tables.OTHER_CAMERA
            yield Clue(f"{result.relation} ({result.scene}): {result.message or result.statement}", weights)
