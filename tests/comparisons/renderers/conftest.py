"""Mitsuba in each of its forms, made once."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache

import pytest

from comparisons.renderers import RendererFailed
from comparisons.renderers.mitsuba import MitsubaRenderer


@pytest.fixture(scope="session")
def mitsuba_form() -> Callable[[str], MitsubaRenderer]:
    """``mitsuba_form("llvm_ad_rgb:prb")``; skips where a compiled variant has no LLVM, which CI has to have."""

    @cache
    def made(form: str) -> MitsubaRenderer:
        try:
            return MitsubaRenderer(form)
        except RendererFailed as error:
            if os.environ.get("CI") == "true":
                raise
            pytest.skip(str(error))

    return made
