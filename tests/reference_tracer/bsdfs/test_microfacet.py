"""GGX: the identities that its distribution and its masking obey, and Walter's formulas as the paper writes them.

Sampling, energy and reciprocity of the two BSDFs are tested in test_bsdf.py, beside those of all others.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from reference_tracer.bsdfs import fresnel, microfacet
from reference_tracer.bsdfs.microfacet import RoughConductorBSDF, RoughDielectricBSDF
from reference_tracer.points import Points
from reference_tracer.bsdfs.specular import DielectricBSDF
from scenes import Dielectric, RoughConductor, RoughDielectric

ALPHAS = [0.001, 0.05, 0.3, 1.0]
COUNT = 5000


def unit(rng: np.random.Generator, count: int) -> np.ndarray:
    d = rng.standard_normal((3, count))
    return d / np.linalg.norm(d, axis=0)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=0)


def up(count: int) -> Points:
    n, surface = np.tile([[0.0], [0.0], [1.0]], count), np.zeros(count, dtype=int)
    return Points(x=np.zeros((3, count)), n=n, surface=surface, ns=n, uv=None)


def facets(alpha: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A grid of normals m: cos θ, azimuth, solid angle. Denser where tan θ is about α, where D has its peak."""
    nodes, weights = np.polynomial.legendre.leggauss(600)
    t = (nodes + 1) / 2  # tan θ = α t / (1 − t), t in (0, 1)
    tangent, slope = alpha * t / (1 - t), alpha / (1 - t) ** 2
    cos = 1 / np.sqrt(1 + tangent**2)
    area = weights / 2 * slope * cos**3 * tangent  # dω = sin θ dθ dφ = tan θ cos³ θ d tan θ dφ
    phi = 2 * np.pi * (np.arange(600) + 0.5) / 600
    shape = (600, 600)
    grid = np.broadcast_to(cos[:, None], shape), np.broadcast_to(phi, shape)
    return *grid, np.broadcast_to(area[:, None] * 2 * np.pi / 600, shape)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_the_facets_cover_the_surface(alpha: float) -> None:
    """∫ D(m) cos θm dm = 1 (Walter et al. 2007, eq. 4)."""
    cos, _, area = facets(alpha)
    assert (microfacet.D(cos, np.array(alpha)) * cos * area).sum() == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("alpha", ALPHAS)
@pytest.mark.parametrize("cosine", [1.0, 0.8, 0.3, 0.05])
def test_what_is_seen_of_the_facets_is_what_is_seen_of_the_surface(alpha: float, cosine: float) -> None:
    """∫ D(m) G1(wo) max(wo·m, 0) dm = cos θo: the constraint that makes G1 what it is (Heitz 2014, §3)."""
    cos, phi, area = facets(alpha)
    facing = np.sqrt((1 - cos**2) * (1 - cosine**2)) * np.cos(phi) + cos * cosine
    seen = microfacet.D(cos, np.array(alpha)) * np.maximum(facing, 0) * area
    G1 = microfacet.G1(np.array(cosine), np.array(alpha))
    assert seen.sum() * G1 == pytest.approx(cosine, rel=2e-5)


def test_masking_and_shadowing() -> None:
    """G2 is 1/(1 + Λi + Λo), at least the product of the two G1, at most the smaller, and that for normal wi."""
    rng = np.random.default_rng(1)
    cos_i, cos_o, alpha = 1 - rng.random((3, 1000)) * 0.999
    G1i, G1o = microfacet.G1(cos_i, alpha), microfacet.G1(cos_o, alpha)
    correlated = np.zeros(len(alpha), dtype=bool)
    G2 = microfacet.G2(cos_i, cos_o, alpha, correlated)
    lambdas = [(np.sqrt(1 + (alpha * np.tan(np.arccos(c))) ** 2) - 1) / 2 for c in (cos_i, cos_o)]
    np.testing.assert_allclose(G2, 1 / (1 + sum(lambdas)), rtol=1e-9)
    np.testing.assert_allclose(G1o, 1 / (1 + lambdas[1]), rtol=1e-9)
    assert (G2 / (G1i * G1o) > 1 - 1e-12).all()
    assert (G2 / np.minimum(G1i, G1o) < 1 + 1e-12).all()
    np.testing.assert_allclose(microfacet.G2(np.ones(1000), cos_o, alpha, correlated), G1o, rtol=1e-12)
    np.testing.assert_allclose(microfacet.G2(cos_i, cos_o, alpha, ~correlated), G1i * G1o, rtol=1e-12)


@pytest.mark.parametrize("alpha", [0.05, 0.3, 1.0])
def test_visible_normals_are_facets_that_are_seen(alpha: float) -> None:
    """They face the viewer, and their mean cos θm is that of their density: cos θ = 0.3, five standard errors."""
    count, cosine = 200_000, 0.3
    wo = np.tile([[np.sqrt(1 - cosine**2)], [0.0], [cosine]], count)
    u = np.random.default_rng(2).random((2, count))
    m = microfacet.square_to_visible_normals(u, wo, np.full(count, alpha))
    assert dot(m, wo).min() >= 0
    assert m[2].min() >= 0
    cos, phi, area = facets(alpha)
    om = np.maximum(np.sqrt((1 - cos**2) * (1 - cosine**2)) * np.cos(phi) + cos * cosine, 0)
    pdf = microfacet.square_to_visible_normals_pdf(om, cos, np.array(cosine), np.array(alpha)) * area
    for values, expected in ((m[2], (pdf * cos).sum()), (dot(m, wo), (pdf * om).sum())):
        assert abs(values.mean() - expected) < 5 * values.std() / np.sqrt(count)


def test_metal_as_walter_writes_it() -> None:
    """Eq. 20 and 33 with tangents and a G made of Λ, in a scene frame that isn't the normal's."""
    rng, alpha, (eta, k) = np.random.default_rng(3), 0.35, (0.4, 2.4)
    n, wi, wo = unit(rng, COUNT), unit(rng, COUNT), unit(rng, COUNT)
    wi, wo = (w * np.sign(dot(n, w)) for w in (wi, wo))
    at = up(COUNT)
    at.n = at.ns = n
    h = (wi + wo) / np.linalg.norm(wi + wo, axis=0)
    theta_m, theta_i, theta_o = (np.arccos(dot(n, w)) for w in (h, wi, wo))
    D = alpha**2 / (np.pi * np.cos(theta_m) ** 4 * (alpha**2 + np.tan(theta_m) ** 2) ** 2)
    lambdas = [(np.sqrt(1 + (alpha * np.tan(theta)) ** 2) - 1) / 2 for theta in (theta_i, theta_o)]
    F = fresnel.conductor(dot(h, wi), np.array([[eta]]), np.array([[k]]))[0]
    expected = F * D / (1 + sum(lambdas)) / (4 * np.cos(theta_i) * np.cos(theta_o))
    bsdf = RoughConductorBSDF([RoughConductor((eta,), (k,), alpha)], 1)
    np.testing.assert_allclose(bsdf.f(at, wi, wo)[0], expected, rtol=1e-8)


@pytest.mark.parametrize(("interior", "exterior"), [(1.5, 1.0), (1.0, 1.33), (1.8, 1.4)])
def test_refraction_as_walter_writes_it(interior: float, exterior: float) -> None:
    """Eq. 16 and 21: h = −(η_i i + η_o o), turned to the medium of lower index, and f in terms of both indices."""
    rng, alpha = np.random.default_rng(4), 0.5
    wi, wo = unit(rng, COUNT), unit(rng, COUNT)
    wi[2] = -np.sign(wo[2]) * np.abs(wi[2])
    index_o, index_i = (np.where(w[2] > 0, exterior, interior) for w in (wo, wi))
    h = -(index_i * wi + index_o * wo)
    h /= np.linalg.norm(h, axis=0)
    h *= 1 if interior > exterior else -1  # now it is on the front, if there is such a facet
    ih, oh, cos_m = dot(wi, h), dot(wo, h), h[2]
    valid = (cos_m > 0) & (ih * wi[2] > 0) & (oh * wo[2] > 0)
    assert 500 < valid.sum() < COUNT - 500
    ratio = np.maximum(np.where(valid, index_i / index_o, 1) ** 2 - 1 + oh**2, 0)
    c, g = np.abs(oh), np.sqrt(ratio)
    F = ((g - c) / (g + c)) ** 2 / 2 * (1 + ((c * (g + c) - 1) / (c * (g - c) + 1)) ** 2)  # eq. 22
    tangent = np.sqrt(1 - cos_m**2) / np.abs(cos_m)
    D = alpha**2 / (np.pi * cos_m**4 * (alpha**2 + tangent**2) ** 2)
    lambdas = [(np.sqrt(1 + alpha**2 * (1 / w[2] ** 2 - 1)) - 1) / 2 for w in (wi, wo)]
    G = 1 / (1 + sum(lambdas))
    expected = np.abs(ih * oh / (wi[2] * wo[2])) * index_o**2 * (1 - F) * G * D
    expected *= valid / (index_i * ih + index_o * oh) ** 2
    bsdf = RoughDielectricBSDF([RoughDielectric(alpha, interior, exterior)], 1)
    np.testing.assert_allclose(bsdf.f(up(COUNT), wi, wo)[0], expected, rtol=1e-7, atol=1e-13)


@pytest.mark.parametrize("cosine", [0.9, 0.4, -0.9, -0.8])
def test_hardly_rough_glass_is_smooth_glass(cosine: float) -> None:
    """At α = 0.001 directions are those of a smooth boundary, to 0.01, and nearly nothing is lost."""
    wo = np.tile([[np.sqrt(1 - cosine**2)], [0.0], [cosine]], COUNT)
    u = np.random.default_rng(5).random((3, COUNT))
    rough = RoughDielectricBSDF([RoughDielectric(0.001)], 1).sample(up(COUNT), wo, u)
    smooth = DielectricBSDF([Dielectric()], 1).sample(up(COUNT), wo, u)
    same = rough.wi[2] * smooth.wi[2] > 0  # F differs a little between facets
    assert same.mean() > 0.99
    off = np.abs(rough.wi - smooth.wi).max(axis=0)[same]
    assert np.quantile(off, 0.9) < 0.01
    np.testing.assert_allclose(rough.weight[:, same], smooth.weight[:, same], rtol=1e-3)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_extreme_directions_and_numbers(alpha: float) -> None:
    """Along the surface, along the normal, opposite, and from the ends of the unit interval: finite or nothing."""
    ends = np.array([0.0, 1e-300, 1e-9, 0.25, 0.5, np.nextafter(1, 0)])
    angles = np.array([0.0, 1e-300, 1e-9, 0.3, 1.0, np.pi / 2 - 1e-9, np.pi / 2, 2.0, np.pi])
    u = np.stack(np.meshgrid(ends, ends, ends)).reshape(3, -1)
    u = np.tile(u, len(angles))
    theta = np.repeat(angles, len(ends) ** 3)
    wo = np.stack([np.sin(theta), 0 * theta, np.cos(theta)])
    at = up(len(theta))
    metal = RoughConductorBSDF([RoughConductor((0.2,), (3.9,), alpha)], 1)
    glass = RoughDielectricBSDF([RoughDielectric(alpha)], 1)
    for bsdf in (metal, glass):
        sample = bsdf.sample(at, wo, u)
        assert np.isfinite(sample.wi).all()
        np.testing.assert_allclose(np.linalg.norm(sample.wi[:, sample.pdf > 0], axis=0), 1, rtol=1e-9)
        assert ((sample.weight >= 0) & (sample.weight < 2.26)).all()
        for wi in (sample.wi, wo, -wo, np.roll(wo, 11, axis=1)):
            f, pdf = bsdf.f(at, wi, wo), bsdf.pdf(at, wi, wo)
            assert (np.isfinite(f) & (f >= 0)).all()
            assert (np.isfinite(pdf) & (pdf >= 0)).all()


def test_the_loss_grows_with_roughness() -> None:
    """From none; there is none on the back of a metal, which is black however it is made."""
    cosines = np.array([[1.0, 0.5], [0.2, -0.5]])
    losses = []
    for alpha in (0.001, 0.1, 0.5, 1.0):
        metal = RoughConductorBSDF([RoughConductor((1.0,), (1e9,), alpha)], 1)
        losses.append(metal.single_scattering_loss(0, cosines))
        assert losses[-1].shape == (2, 2)
        assert losses[-1][1, 1] == 0
    assert losses[0].max() < 1e-4
    for less, more in pairwise(losses):
        assert (more >= less).all()


@pytest.mark.parametrize("alpha", [0.1, 0.4, 1.0])
def test_the_loss_of_glass_that_is_all_but_matched(alpha: float) -> None:
    """Every facet lets light through straight on: what is lost is 1 − G2/G1 at wi = −wo, that is Λ / (1 + 2Λ)."""
    cosines = np.array([1.0, 0.6, 0.2, -0.6])
    glass = RoughDielectricBSDF([RoughDielectric(alpha, 1 + 1e-7)], 1)
    masked = (np.sqrt(1 + alpha**2 * (1 / cosines**2 - 1)) - 1) / 2
    np.testing.assert_allclose(
        glass.single_scattering_loss(0, cosines), masked / (1 + 2 * masked), rtol=1e-3, atol=1e-6
    )
