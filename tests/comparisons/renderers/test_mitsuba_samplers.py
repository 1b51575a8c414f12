from __future__ import annotations

import pytest

from comparisons.renderers.mitsuba_names import Form, shown
from comparisons.renderers.mitsuba_samplers import calls


@pytest.mark.parametrize("form", shown(), ids=lambda form: form.name)
@pytest.mark.parametrize("spp", [1, 4, 11, 50, 400])
def test_calls_make_what_is_asked_for_in_whole_units(form: Form, spp: int) -> None:
    made = calls(form, spp, 64 * 64)
    assert sum(made) % form.spp_unit == 0
    assert spp <= sum(made) < spp + form.spp_unit
    assert all(count % form.spp_unit == 0 for count in made)


def test_the_table_of_the_module() -> None:
    assert calls(Form(), 3, 100) == [1, 1, 1]
    assert calls(Form("scalar_rgb", "ptracer"), 37, 100) == [37]
    assert calls(Form("llvm_ad_rgb"), 44, 100) == [32, 8, 4]
    assert calls(Form("llvm_ad_rgb"), 44, 256 * 256) == [16, 16, 8, 4]
    assert calls(Form("llvm_ad_rgb"), 8, 4096 * 4096) == [4, 4]
    assert calls(Form("llvm_ad_rgb", "ptracer"), 20, 100) == [16, 16]
    assert calls(Form("scalar_rgb", "path", "ldsampler"), 1, 100) == [16]
    assert calls(Form("llvm_ad_rgb", "path", "orthogonal"), 26, 100) == [25, 25]


def test_mitsuba_takes_these_numbers_as_they_are() -> None:
    mitsuba = pytest.importorskip("mitsuba")
    mitsuba.set_variant("scalar_rgb")
    for sampler in ("stratified", "multijitter", "orthogonal", "ldsampler"):
        unit = Form(sampler=sampler).spp_unit
        made = mitsuba.load_dict({"type": sampler, "sample_count": unit})
        assert made.sample_count() == unit
        assert unit > 1
