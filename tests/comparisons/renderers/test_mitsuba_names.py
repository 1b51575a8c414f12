from __future__ import annotations

import subprocess
import sys

import pytest

from comparisons.renderers import canonical, traits
from comparisons.renderers.mitsuba_names import (
    INTEGRATORS,
    SAMPLERS,
    VARIANTS,
    Form,
    FormError,
    entry_of,
    full_name,
    parse,
    shown,
    shown_names,
    spelled_out,
)
from scenes import UnknownNameError


@pytest.mark.parametrize(
    ("name", "full"),
    [
        ("mitsuba", "mitsuba:scalar_rgb"),
        ("mitsuba:scalar_rgb", "mitsuba:scalar_rgb"),
        ("mitsuba:scalar_rgb:path", "mitsuba:scalar_rgb"),
        ("mitsuba:scalar_rgb:path:independent", "mitsuba:scalar_rgb"),
        ("mitsuba:llvm_ad_rgb:path", "mitsuba:llvm_ad_rgb"),
        ("mitsuba:llvm_ad_rgb:ptracer:independent", "mitsuba:llvm_ad_rgb:ptracer"),
        ("mitsuba:scalar_rgb:path:ldsampler", "mitsuba:scalar_rgb:path:ldsampler"),
        ("mitsuba:scalar_spectral:volpathmis:orthogonal", "mitsuba:scalar_spectral:volpathmis:orthogonal"),
        ("reference:mis", "reference:mis"),
    ],
)
def test_defaults_are_left_out_at_the_end(name: str, full: str) -> None:
    assert full_name(name) == canonical(name) == full
    assert full_name(spelled_out(name)) == full


def test_every_form_comes_back_from_its_name() -> None:
    forms = [Form(v, i, s) for v in VARIANTS for i in INTEGRATORS for s in SAMPLERS]
    possible = [form for form in forms if form.integrator != "prb" or form.compiled]
    assert len(forms) - len(possible) == 2 * len(SAMPLERS)
    assert len({form.name for form in possible}) == len(possible)
    for form in possible:
        assert parse(form.name) == parse(form.spelled_out) == form
        entry = entry_of(form.name)
        assert entry is not None
        assert (entry.module, entry.argument) == ("mitsuba", ":".join(form))
        assert traits(form.name) == entry


def test_the_list_has_every_integrator_in_every_variant_and_every_sampler() -> None:
    names = shown_names()
    assert len(set(names)) == len(names)
    for form in (Form("llvm_ad_rgb", "prb"), Form("scalar_spectral", "ptracer"), Form(sampler="ldsampler")):
        assert form.name in names
    assert {form.integrator for form in shown()} == INTEGRATORS.keys()
    assert {form.sampler for form in shown()} == SAMPLERS.keys()
    assert all(form.integrator != "prb" or form.compiled for form in shown())


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        (
            "mitsuba:scalar",
            "no renderer is called 'mitsuba:scalar': there is no variant 'scalar', but scalar_rgb",
        ),
        ("mitsuba:volpath", "scalar_spectral; the integrator volpath is mitsuba:scalar_rgb:volpath$"),
        ("mitsuba:prb", "; the integrator prb is mitsuba:llvm_ad_rgb:prb$"),
        ("mitsuba:scalar_rgb:ldsampler", "; the sampler ldsampler is mitsuba:scalar_rgb:path:ldsampler$"),
        ("mitsuba:scalar_rgb:pth", "there is no integrator 'pth', but path, volpath"),
        ("mitsuba:scalar_rgb:path:sobol", "there is no sampler 'sobol', but independent, stratified"),
        (
            "mitsuba:scalar_rgb:path:ldsampler:x",
            "expected mitsuba:VARIANT:INTEGRATOR:SAMPLER, and nothing more",
        ),
        ("mitsuba:scalar_rgb:prb", "such as mitsuba:llvm_ad_rgb:prb"),
        ("mitsuba:scalar_spectral:prb:ldsampler", "such as mitsuba:llvm_ad_rgb:prb:ldsampler"),
    ],
)
def test_what_there_is_not(name: str, complaint: str) -> None:
    for look in (parse, canonical, entry_of):
        with pytest.raises(FormError, match=complaint):
            look(name)
    assert issubclass(FormError, UnknownNameError)


def test_others_are_none_of_the_family() -> None:
    assert entry_of("reference:mis") is None
    assert entry_of("mitsubas") is None


def test_direct_ends_at_bounce_one() -> None:
    entries = [entry_of(f"mitsuba:scalar_rgb:{integrator}") for integrator in ("direct", "path")]
    assert [entry.last_bounce for entry in entries if entry] == [1, None]


def test_nothing_is_imported_for_a_name() -> None:
    code = (
        "import sys; from comparisons.renderers import mitsuba, mitsuba_names, canonical;"
        "canonical('mitsuba:llvm_ad_rgb:prb'); mitsuba.supports();"
        "assert not {'mitsuba', 'drjit'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("name", "differences"),
    [
        ("mitsuba", False),
        ("mitsuba:scalar_rgb:path:ldsampler", False),
        ("mitsuba:llvm_ad_rgb:ptracer:stratified", False),
        ("mitsuba:scalar_rgb:path:multijitter", True),
        ("mitsuba:scalar_spectral:ptracer", True),
    ],
)
def test_forms_whose_depths_share_no_paths_have_differences_of_both_signs(
    name: str, differences: bool
) -> None:
    entry = entry_of(name)
    assert entry is not None
    assert entry.differences == differences
