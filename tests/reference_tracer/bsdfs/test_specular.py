"""Mirror, glass and metal: directions by the laws of reflection and refraction, shares by Fresnel."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from reference_tracer.bsdfs import fresnel
from reference_tracer.bsdfs.bsdf import BSDF
from reference_tracer.points import NOWHERE, Points
from reference_tracer.bsdfs.specular import ConductorBSDF, DielectricBSDF, MirrorBSDF
from scenes import Conductor, Dielectric, Mirror

COUNT = 2000
MIRROR = MirrorBSDF([Mirror((0.9, 0.5, 0.1))], 3)
METAL = ConductorBSDF([Conductor((0.2, 0.9, 1.1), (3.9, 2.5, 2.2))], 3)
GLASS = DielectricBSDF([Dielectric(1.5)], 3)
BUBBLE = DielectricBSDF([Dielectric(1.0, 1.5)], 3)
ALL = [MIRROR, METAL, GLASS, BUBBLE]


def unit(rng: np.random.Generator, count: int) -> np.ndarray:
    d = rng.standard_normal((3, count))
    return d / np.linalg.norm(d, axis=0)


def points(n: np.ndarray, ns: np.ndarray | None = None) -> Points:
    count = n.shape[1]
    surface = np.zeros(count, dtype=int)
    return Points(x=np.zeros((3, count)), n=n, surface=surface, ns=n if ns is None else ns, uv=None)


def tilted(n: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Shading normals up to some 50 degrees off."""
    ns = n + 0.8 * unit(rng, n.shape[1])
    return ns / np.linalg.norm(ns, axis=0)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=0)


@pytest.mark.parametrize("bsdf", ALL)
def test_smooth_lobes_there_are_none(bsdf: BSDF) -> None:
    rng = np.random.default_rng(1)
    at, wi, wo = points(unit(rng, COUNT)), unit(rng, COUNT), unit(rng, COUNT)
    assert bsdf.f(at, wi, wo).shape == (3, COUNT)
    assert not bsdf.f(at, wi, wo).any()
    assert not bsdf.pdf(at, wi, wo).any()
    assert not bsdf.single_scattering_loss(0, np.linspace(-1, 1, 5)).any()
    assert not bsdf.f(at, bsdf.sample(at, wo, rng.random((3, COUNT))).wi, wo).any()


@pytest.mark.parametrize("bsdf", [MIRROR, METAL])
def test_a_mirror_turns_the_direction_half_round_the_normal(bsdf: BSDF) -> None:
    rng = np.random.default_rng(2)
    at, wo = points(unit(rng, COUNT)), unit(rng, COUNT)
    sample, front = bsdf.sample(at, wo, rng.random((2, COUNT))), dot(at.n, wo) > 0
    np.testing.assert_allclose(dot(sample.wi, at.n), dot(wo, at.n), atol=1e-14)
    np.testing.assert_allclose(np.cross(sample.wi + wo, at.n, axis=0), 0, atol=1e-14)
    np.testing.assert_array_equal(sample.pdf, np.where(front, np.inf, 0))
    assert not sample.weight[:, ~front].any()
    assert not bsdf.needs_choice


def test_what_mirror_and_metal_reflect() -> None:
    cos_o = np.linspace(0.01, 1, 100)
    up = np.tile([[0.0], [0.0], [1.0]], 100)
    wo = np.stack([np.sqrt(1 - cos_o**2), 0 * cos_o, cos_o])
    weight = MIRROR.sample(points(up), wo, np.zeros((2, 100))).weight
    np.testing.assert_array_equal(weight, np.tile([[0.9], [0.5], [0.1]], 100))
    weight = METAL.sample(points(up), wo, np.zeros((2, 100))).weight
    assert weight[0, -1] == pytest.approx((0.8**2 + 3.9**2) / (1.2**2 + 3.9**2), rel=1e-13)
    eta, k = np.array([[0.2], [0.9], [1.1]]), np.array([[3.9], [2.5], [2.2]])
    np.testing.assert_allclose(weight, fresnel.conductor(cos_o, eta, k), rtol=1e-12)


@pytest.mark.parametrize(("bsdf", "front", "behind"), [(GLASS, 1.0, 1.5), (BUBBLE, 1.5, 1.0)])
def test_snell_and_total_internal_reflection(bsdf: BSDF, front: float, behind: float) -> None:
    """η sin θ is the same on both sides, the three directions lie in a plane, and radiance scales by η²."""
    rng = np.random.default_rng(3)
    at, wo = points(unit(rng, COUNT)), unit(rng, COUNT)
    sample = bsdf.sample(at, wo, np.stack([*rng.random((2, COUNT)), np.full(COUNT, 1 - 1e-16)]))
    cos_o, cos_i = dot(wo, at.n), dot(sample.wi, at.n)
    here, there = (np.where(cos_o > 0, *pair) for pair in ((front, behind), (behind, front)))
    sin_o = np.linalg.norm(np.cross(at.n, wo, axis=0), axis=0)
    total = here * sin_o > there
    assert 650 < total.sum() < 850
    np.testing.assert_allclose(sample.wi[:, total] + wo[:, total], (2 * cos_o * at.n)[:, total], atol=1e-14)
    np.testing.assert_array_equal(sample.weight[:, total], 1)
    assert (cos_i * cos_o < 0)[~total].all()
    left, right = here * np.cross(at.n, wo, axis=0), -there * np.cross(at.n, sample.wi, axis=0)
    np.testing.assert_allclose(left[:, ~total], right[:, ~total], atol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(sample.wi, axis=0), 1, rtol=1e-13)
    scale = np.where(total, 1, (here / there) ** 2)
    np.testing.assert_allclose(sample.weight, np.tile(scale, (3, 1)), rtol=1e-14)
    assert np.isinf(sample.pdf).all()


@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.1, -1.0, -0.8, -0.5])
def test_how_often_glass_reflects(cosine: float) -> None:
    """As often as Fresnel says; an F that is off by 0.005 would be found, were it not 1."""
    count = 400_000
    wo = np.tile([[np.sqrt(1 - cosine**2)], [0.0], [cosine]], count)
    at = points(np.tile([[0.0], [0.0], [1.0]], count))
    sample = GLASS.sample(at, wo, np.random.default_rng(4).random((3, count)))
    reflects = int((sample.wi[2] * cosine > 0).sum())
    eta = 1.5 if cosine > 0 else 1 / 1.5
    F = fresnel.dielectric(np.full(1, abs(cosine)), np.full(1, eta))[0]
    assert stats.binomtest(reflects, count, min(F, 1)).pvalue > 1e-6
    if F < 1:
        assert stats.binomtest(reflects, count, F + 0.005).pvalue < 1e-6
    # energy: what is reflected, and what is refracted over η², are all there is
    power = np.where(sample.wi[2] * cosine > 0, sample.weight[0], sample.weight[0] * eta**2)
    np.testing.assert_allclose(power, 1, rtol=1e-14)


def test_through_a_pane_and_out_again() -> None:
    """In and out the factors 1/η² and η² cancel, and the direction is what it was."""
    rng = np.random.default_rng(5)
    wo = unit(rng, COUNT)
    n, u = np.where(wo[2] > 0, 1, -1) * np.tile([[0.0], [0.0], [1.0]], COUNT), np.full((3, COUNT), 1 - 1e-16)
    first = GLASS.sample(points(n), wo, u)
    second = GLASS.sample(points(-n), -first.wi, u)
    np.testing.assert_allclose(second.wi, -wo, atol=1e-9)
    np.testing.assert_allclose(first.weight * second.weight, 1, rtol=1e-14)
    np.testing.assert_allclose(first.weight, 1 / 2.25, rtol=1e-14)


@pytest.mark.parametrize("bsdf", ALL)
def test_shading_normals(bsdf: BSDF) -> None:
    """Directions are those about ns; one on another side of n than it should be carries nothing."""
    rng = np.random.default_rng(7)
    n, wo = unit(rng, COUNT), unit(rng, COUNT)
    ns = tilted(n, rng)
    sample = bsdf.sample(points(n, ns), wo, rng.random((3, COUNT)))
    agree = (dot(n, wo) * dot(ns, wo) > 0) & (dot(n, sample.wi) * dot(ns, sample.wi) > 0)
    if bsdf in (MIRROR, METAL):
        agree &= dot(n, wo) > 0
    assert 50 < (~agree).sum() < COUNT - 500
    np.testing.assert_array_equal(sample.weight[0] > 0, agree)
    np.testing.assert_array_equal(sample.pdf, np.where(agree, np.inf, 0))
    flat = bsdf.sample(points(ns), wo, np.random.default_rng(8).random((3, COUNT)))
    same = bsdf.sample(points(n, ns), wo, np.random.default_rng(8).random((3, COUNT)))
    np.testing.assert_array_equal(flat.wi[:, agree], same.wi[:, agree])


@pytest.mark.parametrize("bsdf", ALL)
def test_nowhere_is_black(bsdf: BSDF) -> None:
    rng = np.random.default_rng(9)
    at = points(unit(rng, 50))
    at.surface = np.full(50, NOWHERE)
    sample = bsdf.sample(at, at.n, rng.random((3, 50)))
    assert not sample.weight.any()
    assert not sample.pdf.any()


@pytest.mark.parametrize("channels", [1, 3, 5])
def test_any_number_of_channels(channels: int) -> None:
    """Each channel of a metal is a metal of its own; glass has as many as it is asked for."""
    rng = np.random.default_rng(10)
    eta, k = rng.random((2, channels)) + 0.2
    at, wo, u = points(unit(rng, 200)), unit(rng, 200), rng.random((3, 200))
    weight = ConductorBSDF([Conductor(tuple(eta), tuple(k))], channels).sample(at, wo, u).weight
    for i in range(channels):
        alone = ConductorBSDF([Conductor((eta[i],), (k[i],))], 1).sample(at, wo, u).weight
        np.testing.assert_array_equal(weight[i], alone[0])
    assert DielectricBSDF([Dielectric()], channels).sample(at, wo, u).weight.shape == (channels, 200)
    assert MirrorBSDF([Mirror((0.5,) * channels)], channels).sample(at, wo, u).weight.shape == (channels, 200)
