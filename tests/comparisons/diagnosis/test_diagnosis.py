"""What is named, on made-up results; how often it is right is measured on planted faults."""

from __future__ import annotations

from collections.abc import Callable

from comparisons.diagnosis import diagnose, diagnoses
from comparisons.results import Comparison, Hint

Make = Callable[..., Comparison]
TRUTH = [1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125]


def off(*factors: float) -> list[float]:
    return [t * f for t, f in zip(TRUTH, factors, strict=True)]


def test_each_step_off_by_a_factor_is_reflection(made: Make) -> None:
    found = diagnose([made(TRUTH, off(*(1.02**k for k in range(6))))])
    assert found.suspect == "R"
    assert found.sentence.startswith("R, reflection: a BSDF: bounce 1 is 2 ± 0.01 % too bright")
    far_off = diagnose([made(TRUTH, off(*(3.1**k for k in range(6))))])
    assert "bounce 1 is 210 ± 0.01 % too bright" in far_off.sentence


def test_a_single_bounce_is_the_series(made: Make) -> None:
    assert diagnose([made(TRUTH, off(1, 1, 1, 0.5, 1, 1))]).suspect == "series"


def test_black_lamps_are_emission(made: Make) -> None:
    assert diagnose([made(TRUTH, off(0, 1, 1, 1, 1, 1))]).suspect == "E"


def test_an_image_that_was_turned_is_the_sensor(made: Make) -> None:
    hint = Hint(kinds=["turned"], text="It fits the truth far better turned upside down: 2 % is left then.")
    found = diagnose([made(TRUTH, TRUTH, by_tile=range(6), hints=[hint])])
    assert found.suspect == "sensor"


def test_the_same_factor_in_everything_may_be_two_things(made: Make) -> None:
    """Emission or exposure: what is thin evidence is said to be, with a case that tells."""
    found = diagnose([made(TRUTH, off(*[1.02] * 6))])
    assert found.suspect is None
    assert set(found.also_possible) >= {"E", "sensor"}
    assert found.sentence.startswith("Can't tell; it may be ")
    assert found.next_case


def test_one_kind_of_lamp_that_is_wrong_tells_them_apart(made: Make) -> None:
    wrong = made(TRUTH, off(*[1.02] * 6), features=["quad", "lambertian", "area"])
    right = [
        made(TRUTH, TRUTH, case=name, features=["quad", "lambertian", kind])
        for name, kind in (("a", "point"), ("b", "directional"), ("c", "constant"))
    ]
    found = diagnose([wrong, *right])
    assert (found.suspect, found.next_case) == ("E", "")


def test_what_is_right_elsewhere_is_wrong_where_it_stands(made: Make) -> None:
    """The same lights on the same materials pass five times: neither is wrong by itself."""
    shone_on = {"features": ["quad", "lambertian", "mirror", "area"]}
    wrong = made([1.0, 0.5], [1.0, 0.4], **shone_on)
    right = [made([1.0, 0.5], [1.0, 0.5], case=name, **shone_on) for name in "abcde"]

    def said(failed: Comparison, passed: list[Comparison]) -> bool:
        return any("right in other cases (5 passed)" in text for text in diagnose([failed, *passed]).evidence)

    assert said(wrong, right)
    assert not said(wrong, right[1:])
    assert not said(made([1.0, 0.5], [1.0, 0.4], features=["quad", "lambertian", "constant"]), right)
    assert not said(
        made([1.0, 0.5], [1.0, 0.4], features=["quad", "lambertian"]), right
    )  # lit by nothing known


def test_a_furnace_of_half_the_albedo_is_not_counted_from_another_number(made: Make) -> None:
    """Half of every bounce is the next one there; other cases tell which it is."""
    half = off(*[0.5] * 6)
    others = [
        made([1.0, 0.2, 0.15], [0.5, 0.1, 0.075], case=name, features=["quad", kind])
        for name, kind in (("a", "area"), ("b", "constant"))
    ]
    texts = " ".join(diagnose([made(TRUTH, half), *others]).evidence)
    assert "light of bounce" not in texts
    assert "by the same factor" in texts


def test_a_lamp_is_not_blamed_where_direct_light_is_right(made: Make) -> None:
    lamp = {"features": ["quad", "lambertian", "area", "angular_profile"]}
    wrong = made(TRUTH, off(1, 1, 1, 0.9, 0.8, 0.7), **lamp)
    right = [made(TRUTH, TRUTH, case=name, features=["quad", "lambertian", "area"]) for name in "abc"]
    assert not any("angular_profile" in text for text in diagnose([wrong, *right]).evidence)


def test_a_seed_that_does_nothing_is_the_sampler(made: Make) -> None:
    message = "takes no notice of its seed: seeds 1 and 2 give the same image"
    found = diagnose([made([], [], verdict="error", message=message)])
    assert found.suspect == "sampler"


def test_each_renderer_that_failed_has_its_own(made: Make) -> None:
    results = [
        made(TRUTH, TRUTH, renderer="right"),
        made(TRUTH, off(0, 1, 1, 1, 1, 1), renderer="wrong"),
        made([], [], renderer="crashed", verdict="error", message="out of memory"),
    ]
    assert [(d.renderer, d.suspect) for d in diagnoses(results)] == [("wrong", "E")]
