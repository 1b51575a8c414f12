"""Fresnel's equations against Fresnel's laws of sines and tangents, and against the values everybody knows."""

from __future__ import annotations

import numpy as np
import pytest

from reference_tracer.bsdfs import fresnel

COSINES = np.concatenate([np.geomspace(1e-6, 0.1, 20), np.linspace(0.11, 1, 50)])
INDICES = [1.0003, 1.33, 1.5, 2.4, 1 / 1.33, 1 / 1.5, 1 / 2.4]


@pytest.mark.parametrize("eta", INDICES)
def test_sine_and_tangent_law(eta: float) -> None:
    """r_s = −sin(θo − θi) / sin(θo + θi), r_p = tan(θo − θi) / tan(θo + θi), below the critical angle."""
    theta = np.arccos(COSINES[:-1])  # both laws are 0/0 at normal incidence
    theta = theta[np.sin(theta) < 0.999 * min(eta, 1)]
    other = np.arcsin(np.sin(theta) / eta)
    r_s = np.sin(theta - other) / np.sin(theta + other)
    r_p = np.tan(theta - other) / np.tan(theta + other)
    F = fresnel.dielectric(np.cos(theta), np.full_like(theta, eta))
    np.testing.assert_allclose(F, (r_s**2 + r_p**2) / 2, rtol=1e-8)
    np.testing.assert_allclose(fresnel.refracted(np.cos(theta), eta), eta * np.cos(other), rtol=1e-9)


def test_values_of_glass() -> None:
    one, grazing, glass = np.ones(1), np.full(1, 1e-9), np.full(1, 1.5)
    assert fresnel.dielectric(one, glass)[0] == pytest.approx(0.04, rel=1e-14)
    assert fresnel.dielectric(one, 1 / glass)[0] == pytest.approx(0.04, rel=1e-14)
    assert fresnel.dielectric(grazing, glass)[0] == pytest.approx(1, abs=1e-8)
    assert fresnel.dielectric(np.full(1, 0.3), one)[0] == 0  # no boundary at all
    # Brewster's angle, tan θ = η: only r_s is left, and it is (η² − 1) / (η² + 1)
    brewster = np.cos(np.arctan(glass))
    assert fresnel.dielectric(brewster, glass)[0] == pytest.approx((1.25 / 3.25) ** 2 / 2, rel=1e-13)


def test_total_internal_reflection() -> None:
    """Beyond the critical angle, sin θ = η, everything is reflected; just before it not all."""
    eta = np.full(50, 1 / 1.5)
    sines = np.linspace(1 / 1.5 + 1e-9, 1, 50)
    np.testing.assert_array_equal(fresnel.dielectric(np.sqrt(1 - sines**2) + 1e-150, eta), 1)
    assert not fresnel.refracted(np.sqrt(1 - sines**2), eta).any()
    before = np.sqrt(1 - (1 / 1.5 - 1e-6) ** 2)
    assert 0.9 < fresnel.dielectric(np.full(1, before), eta[:1])[0] < 0.999


@pytest.mark.parametrize("eta", INDICES)
def test_a_boundary_reflects_as_much_from_either_side(eta: float) -> None:
    inside = fresnel.refracted(COSINES, eta) / eta
    seen = inside > 0
    other = fresnel.dielectric(inside[seen], 1 / np.full(seen.sum(), eta))
    np.testing.assert_allclose(fresnel.dielectric(COSINES[seen], eta), other, rtol=1e-6)


@pytest.mark.parametrize("eta", INDICES)
def test_a_metal_that_absorbs_nothing_is_glass(eta: float) -> None:
    """With k = 0 the two agree, through total internal reflection too."""
    n, k = np.full((2, len(COSINES)), eta), np.zeros((2, len(COSINES)))
    expected = np.tile(fresnel.dielectric(COSINES, n[0]), (2, 1))
    np.testing.assert_allclose(fresnel.conductor(COSINES, n, k), expected, rtol=1e-10, atol=1e-15)


@pytest.mark.parametrize(("eta", "k"), [(0.2, 3.9), (1.5, 7.6), (1.1, 0.01), (4.0, 0.3), (0.05, 0.2)])
def test_metal_against_its_real_form(eta: float, k: float) -> None:
    """(a + ib)² = (η + ik)² − sin² θ solved for real a and b; R_p follows from R_s (Born and Wolf, §14.2)."""
    c, s2 = COSINES, 1 - COSINES**2
    real, imaginary = eta**2 - k**2 - s2, 2 * eta * k
    modulus = np.sqrt(real**2 + imaginary**2)  # a² + b²
    a = np.sqrt((modulus + real) / 2)
    R_s = (modulus - 2 * a * c + c**2) / (modulus + 2 * a * c + c**2)
    tangent = s2 / c  # sin θ tan θ
    ratio = (modulus - 2 * a * tangent + tangent**2) / (modulus + 2 * a * tangent + tangent**2)
    F = fresnel.conductor(c, np.full((1, len(c)), eta), np.full((1, len(c)), k))[0]
    np.testing.assert_allclose(F, R_s * (1 + ratio) / 2, rtol=1e-9)
    assert F[-1] == pytest.approx(((eta - 1) ** 2 + k**2) / ((eta + 1) ** 2 + k**2), rel=1e-13)
    assert F[0] == pytest.approx(1, abs=1e-3)


def test_every_channel_has_its_own_index() -> None:
    eta, k = np.array([[0.2], [0.9], [1.1], [1.5], [2.0]]), np.array([[3.9], [2.5], [2.2], [7.6], [0.0]])
    wide = fresnel.conductor(COSINES, eta * np.ones(len(COSINES)), k * np.ones(len(COSINES)))
    assert wide.shape == (5, len(COSINES))
    for row, n, absorption in zip(wide, eta, k, strict=True):
        alone = fresnel.conductor(COSINES, n * np.ones((1, len(COSINES))), absorption * np.ones((1, 1)))
        np.testing.assert_array_equal(row, alone[0])
