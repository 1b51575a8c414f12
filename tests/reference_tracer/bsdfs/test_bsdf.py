"""What every BSDF with a smooth lobe has to satisfy: χ², weights, reciprocity, energy, sides, channels.

Each stands for its type, some for a hard corner of it. Integrals over directions are made here, on grids of
z = cos θ and azimuth of their own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from reference_tracer.bsdfs.bsdf import BSDF, BSDFSample
from reference_tracer.bsdfs.microfacet import RoughConductorBSDF, RoughDielectricBSDF
from reference_tracer.points import NOWHERE, Points
from reference_tracer.reflection import BlendBSDF, LambertianBSDF
from scenes import Blend, Conductor, Dielectric, Lambertian, Mirror, RoughConductor, RoughDielectric

Follows = Callable[[np.ndarray, np.ndarray], bool]

COUNT = 200_000
ROWS, COLUMNS = 40, 24
GOLD = ((0.16, 0.42, 1.5), (3.5, 2.5, 1.9))
FROSTED, ROUGH_GOLD = RoughDielectric(0.3), RoughConductor(*GOLD, 0.3)


def metal(alpha: float) -> BSDF:
    return RoughConductorBSDF([RoughConductor(*GOLD, alpha)], 3)


def glass(alpha: float, interior: float = 1.5, exterior: float = 1.0) -> BSDF:
    return RoughDielectricBSDF([RoughDielectric(alpha, interior, exterior)], 3)


BSDFS: dict[str, BSDF] = {
    "lambertian": LambertianBSDF([Lambertian((0.8, 0.3, 0.0))], 3),
    "metal 0.15": metal(0.15),
    "metal 0.4": metal(0.4),
    "metal 1": metal(1.0),
    "separable metal 0.5": RoughConductorBSDF([RoughConductor(*GOLD, 0.5, "separable")], 3),
    "separable glass 0.5": RoughDielectricBSDF([RoughDielectric(0.5, shadowing="separable")], 3),
    "glass 0.15": glass(0.15),
    "glass 0.4": glass(0.4),
    "glass 1": glass(1.0, 2.4),
    "bubble 0.3": glass(0.3, 1.0, 1.33),
    "varnish": BlendBSDF([Blend(Lambertian((0.8, 0.3, 0.0)), ROUGH_GOLD, 0.4)], 3),
    "milk glass": BlendBSDF([Blend(Lambertian((0.8, 0.3, 0.0)), FROSTED, 0.7)], 3),
}
INDEX = {"bubble 0.3": 1 / 1.33, "glass 1": 2.4}
"""Interior over exterior index of refraction, where it isn't 1.5."""
TWO_SIDED = ("separable glass 0.5", "glass 0.15", "glass 0.4", "glass 1", "bubble 0.3", "milk glass")
NARROW = ("metal 0.15", "glass 0.15")
COSINES = (0.95, 0.5, 0.1, -0.95, -0.5, -0.1)
SEEN = [(name, c) for name in BSDFS for c in COSINES if c > 0 or name in TWO_SIDED]


class Grid(NamedTuple):
    """Directions and the solid angle that each stands for."""

    w: np.ndarray
    area: np.ndarray


def unit(rng: np.random.Generator, count: int) -> np.ndarray:
    d = rng.standard_normal((3, count))
    return d / np.linalg.norm(d, axis=0)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=0)


def points(n: np.ndarray, ns: np.ndarray | None = None) -> Points:
    count = n.shape[1]
    surface = np.zeros(count, dtype=int)
    return Points(x=np.zeros((3, count)), n=n, surface=surface, ns=n if ns is None else ns, uv=None)


def up(count: int) -> Points:
    return points(np.tile([[0.0], [0.0], [1.0]], count))


def viewer(cosine: float, count: int) -> np.ndarray:
    """Unit directions of that cosine to +z, off the axes in azimuth."""
    r = np.sqrt(1 - cosine**2)
    return np.tile([[0.8 * r], [-0.6 * r], [cosine]], count)


def rows(name: str, cosine: float) -> np.ndarray:
    """Edges of cells in z. f jumps where the facets that refract stand upright, wo·n + η wi·n = 0: an edge too."""
    edges = np.linspace(-1, 1, ROWS + 1)
    upright = -cosine / relative_index(name, cosine)
    return np.sort(np.append(edges, upright)) if name in TWO_SIDED and abs(upright) < 1 else edges


def relative_index(name: str, cosine: float) -> float:
    """η: the index on the other side over that on the side of a viewer."""
    return INDEX.get(name, 1.5) if cosine > 0 else 1 / INDEX.get(name, 1.5)


def sphere(name: str, cosine: float) -> Grid:
    """Gauss points of cells between edges in z and of equal azimuth; axes of the areas: row, column, point.

    Twice as many in z where an edge of f crosses the cells, and in azimuth where a lobe is narrow: against 12 × 40
    everywhere, mass and energy stay the same to 2e-6, those of glass to 1e-5.
    """
    edges, nodes = rows(name, cosine), (12 if name in TWO_SIDED else 6, 40 if name in NARROW else 20)
    (x, weights), (y, others) = (np.polynomial.legendre.leggauss(count) for count in nodes)
    height, width = np.diff(edges)[:, None], 2 * np.pi / COLUMNS
    z = edges[:-1, None] + height * (x + 1) / 2
    phi = -np.pi + width * (np.arange(COLUMNS)[:, None] + (y + 1) / 2)
    areas = np.einsum("rz,p,c->rczp", height * weights / 2, others / 2 * width, np.ones(COLUMNS))
    z, phi = np.broadcast_arrays(z[:, None, :, None], phi[None, :, None, :])
    r = np.sqrt(1 - z**2)
    w = np.stack([r * np.cos(phi), r * np.sin(phi), z])
    return Grid(w.reshape(3, -1), areas.reshape(len(height), COLUMNS, -1))


def probabilities(
    pdf: Callable[[Points, np.ndarray, np.ndarray], np.ndarray], name: str, cosine: float
) -> np.ndarray:
    """Integrals of a density over each cell of the sphere, good to 1e-4 in sum."""
    grid = sphere(name, cosine)
    count = grid.w.shape[1]
    values = pdf(up(count), grid.w, viewer(cosine, count))
    return (values.reshape(grid.area.shape) * grid.area).sum(axis=2)


def accepts(follows: Follows, counts: np.ndarray, expected: np.ndarray) -> bool:
    """χ² over the cells and over what was refused; small cells are taken together."""
    assert expected.sum() < 1 + 1e-4, "the density has too much mass"
    counts, expected = counts.ravel(), expected.ravel()
    large = expected * COUNT > 50
    rest = max(1 - expected[large].sum(), 0)  # the small cells, and what is refused
    seen = COUNT - counts[large].sum()
    if rest * COUNT < 50:
        assert seen < 150, "directions where there should be none"
        return follows(counts[large], expected[large] / expected[large].sum())
    return follows(np.append(counts[large], seen), np.append(expected[large], rest))


def sampled(name: str, cosine: float) -> BSDFSample:
    u = np.random.default_rng(1).random((3, COUNT))
    return BSDFS[name].sample(up(COUNT), viewer(cosine, COUNT), u)


def histogram(sample: BSDFSample, name: str, cosine: float) -> tuple[np.ndarray, int]:
    """Sampled directions per cell, and how many were refused."""
    kept = sample.pdf > 0
    x, y, z = sample.wi[:, kept]
    bins = (rows(name, cosine), np.linspace(-np.pi, np.pi, COLUMNS + 1))
    counts = np.histogram2d(z, np.arctan2(y, x), bins=bins)[0]
    assert counts.sum() == kept.sum()
    return counts, int((~kept).sum())


@pytest.mark.parametrize(("name", "cosine"), SEEN)
def test_sampling_follows_the_density_and_finds_the_energy(
    name: str, cosine: float, follows: Follows
) -> None:
    sample = sampled(name, cosine)
    counts, refused = histogram(sample, name, cosine)
    expected = probabilities(BSDFS[name].pdf, name, cosine)
    assert accepts(follows, counts, expected)
    # mass and refused samples make one, at five standard errors
    share = 1 - expected.sum()
    assert abs(refused / COUNT - share) < 5 * np.sqrt(max(share, 0) / COUNT) + 1e-4

    # no more leaves than arrives, and sampling finds what quadrature finds, within five standard errors
    total, eta = power(BSDFS[name], cosine, name), relative_index(name, cosine)
    assert (total <= 1 + 1e-4).all()
    weight = sample.weight * np.where(sample.wi[2] * cosine > 0, 1, eta**2)
    error = 5 * weight.std(axis=1) / np.sqrt(COUNT) + 1e-4
    assert (error < 0.01).all(), "no power"
    assert (np.abs(weight.mean(axis=1) - total) < error).all()


@pytest.mark.parametrize(("name", "wrong"), [("metal 0.4", metal(0.42)), ("glass 0.4", glass(0.42))])
@pytest.mark.parametrize("cosine", [0.95, 0.1])
def test_a_wrong_density_is_found(name: str, wrong: BSDF, cosine: float, follows: Follows) -> None:
    """A roughness 5 % off, and a density of m that has not become one of wi."""
    counts, _ = histogram(sampled(name, cosine), name, cosine)
    assert not accepts(follows, counts, probabilities(wrong.pdf, name, cosine))

    def without_jacobian(at: Points, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        m = wi + wo
        m /= np.linalg.norm(m, axis=0)
        pdf = BSDFS[name].pdf(at, wi, wo)
        return np.where(wi[2] * wo[2] > 0, pdf * np.abs(dot(m, wo)), pdf)

    expected = probabilities(without_jacobian, name, cosine)
    assert not accepts(follows, counts, expected * (counts.sum() / COUNT / expected.sum()))


@pytest.mark.parametrize("name", BSDFS)
def test_the_weight_is_f_cos_over_pdf(name: str) -> None:
    bsdf, rng, count = BSDFS[name], np.random.default_rng(2), 20_000
    at, wo = points(unit(rng, count)), unit(rng, count)
    sample = bsdf.sample(at, wo, rng.random((3, count)))
    np.testing.assert_allclose(np.linalg.norm(sample.wi, axis=0), 1, rtol=1e-9)
    assert 0.3 < (sample.pdf > 0).mean() <= 1
    assert not sample.weight[:, sample.pdf == 0].any()
    f_cos = bsdf.f(at, sample.wi, wo) * np.abs(dot(at.n, sample.wi))
    kept = sample.pdf > 0
    np.testing.assert_allclose((sample.weight * sample.pdf)[:, kept], f_cos[:, kept], rtol=1e-6)
    np.testing.assert_allclose(sample.pdf[kept], bsdf.pdf(at, sample.wi, wo)[kept], rtol=1e-6)


@pytest.mark.parametrize("name", BSDFS)
def test_reciprocity(name: str) -> None:
    """f / η_o² is the same with wi and wo exchanged, where η_o is the index on the side of wo."""
    bsdf, rng, count = BSDFS[name], np.random.default_rng(3), 20_000
    at, wi, wo = points(unit(rng, count)), unit(rng, count), unit(rng, count)
    behind = INDEX.get(name, 1.5) if name in TWO_SIDED else 1.0
    index_o, index_i = (np.where(dot(at.n, w) > 0, 1, behind) for w in (wo, wi))
    one, other = bsdf.f(at, wi, wo) / index_o**2, bsdf.f(at, wo, wi) / index_i**2
    assert (one[0] > 0).mean() > 0.2
    np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-14)
    refracted = one[:, dot(at.n, wi) * dot(at.n, wo) < 0]
    assert refracted.any() == (name in TWO_SIDED)


def power(bsdf: BSDF, cosine: float, name: str = "") -> np.ndarray:
    """∫ f |cos θi| dwi per channel, where what is refracted counts η² times."""
    grid, eta = sphere(name, cosine), relative_index(name, cosine)
    count = grid.w.shape[1]
    f_cos = bsdf.f(up(count), grid.w, viewer(cosine, count)) * np.abs(grid.w[2])
    return (f_cos * np.where(grid.w[2] * cosine > 0, 1, eta**2) * grid.area.ravel()).sum(axis=1)


@pytest.mark.parametrize("alpha", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("cosine", [1.0, 0.7, 0.3, 0.1])
def test_a_white_metal_loses_what_it_states(alpha: float, cosine: float) -> None:
    white = RoughConductorBSDF([RoughConductor((1.0,), (1e12,), alpha)], 1)
    loss = white.single_scattering_loss(0, np.array([cosine]))[0]
    assert loss > 0.01
    assert power(white, cosine)[0] == pytest.approx(1 - loss, abs=4e-4)


@pytest.mark.parametrize("alpha", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("cosine", [1.0, 0.7, 0.3, -0.3, -0.7, -1.0])
def test_glass_loses_what_it_states(alpha: float, cosine: float) -> None:
    loss = glass(alpha).single_scattering_loss(0, np.array([cosine]))[0]
    assert loss > 0.01
    assert power(glass(alpha), cosine, "glass 0.4")[0] == pytest.approx(1 - loss, abs=4e-4)


def test_the_loss_of_a_blend_is_that_of_its_parts() -> None:
    cosines = np.array([0.2, 0.9])
    loss = BSDFS["varnish"].single_scattering_loss(0, cosines)
    np.testing.assert_allclose(loss, 0.4 * metal(0.3).single_scattering_loss(0, cosines), rtol=1e-14)
    assert not BSDFS["lambertian"].single_scattering_loss(0, cosines).any()


@pytest.mark.parametrize("name", [name for name in BSDFS if name not in TWO_SIDED])
def test_the_back_is_black(name: str) -> None:
    bsdf, rng, count = BSDFS[name], np.random.default_rng(5), 4000
    at, wi, wo = points(unit(rng, count)), unit(rng, count), unit(rng, count)
    behind = (dot(at.n, wi) < 0) | (dot(at.n, wo) < 0)
    np.testing.assert_array_equal(bsdf.f(at, wi, wo).any(axis=0), ~behind)
    np.testing.assert_array_equal(bsdf.pdf(at, wi, wo) > 0, ~behind)
    sample, seen = bsdf.sample(at, wo, rng.random((3, count))), dot(at.n, wo) > 0
    assert not sample.weight[:, ~seen].any()
    assert not sample.pdf[~seen].any()


@pytest.mark.parametrize("name", BSDFS)
def test_nowhere_is_black(name: str) -> None:
    rng = np.random.default_rng(6)
    at, wi = points(unit(rng, 200)), unit(rng, 200)
    at.surface = np.full(200, NOWHERE)
    sample = BSDFS[name].sample(at, at.n, rng.random((3, 200)))
    assert not BSDFS[name].f(at, wi, at.n).any()
    assert not sample.weight.any()


@pytest.mark.parametrize("name", BSDFS)
def test_shading_normals(name: str) -> None:
    """Values are those about ns, and 0 where ns and n disagree about the side of a direction."""
    bsdf, rng, count = BSDFS[name], np.random.default_rng(7), 4000
    n, wi, wo, u = unit(rng, count), unit(rng, count), unit(rng, count), rng.random((3, count))
    ns = n + 0.8 * unit(rng, count)
    ns /= np.linalg.norm(ns, axis=0)
    agree = (dot(n, wi) * dot(ns, wi) > 0) & (dot(n, wo) * dot(ns, wo) > 0)
    assert 0.3 < agree.mean() < 0.9
    shaded, about_ns = points(n, ns), points(ns)
    np.testing.assert_allclose(bsdf.f(shaded, wi, wo), bsdf.f(about_ns, wi, wo) * agree, rtol=1e-12)
    np.testing.assert_allclose(bsdf.pdf(shaded, wi, wo), bsdf.pdf(about_ns, wi, wo) * agree, rtol=1e-12)
    seen = dot(n, wo) * dot(ns, wo) > 0
    sample, flat = bsdf.sample(shaded, wo, u), bsdf.sample(about_ns, wo, u)
    np.testing.assert_array_equal(sample.wi[:, seen], flat.wi[:, seen])
    assert not sample.weight[:, ~seen].any()
    agree = seen & (dot(n, sample.wi) * dot(ns, sample.wi) > 0)
    np.testing.assert_allclose(sample.weight, flat.weight * agree, rtol=1e-12)
    np.testing.assert_allclose(sample.pdf, flat.pdf * agree, rtol=1e-12)


@pytest.mark.parametrize("channels", [1, 3, 5])
def test_each_channel_is_a_material_of_its_own(channels: int) -> None:
    rng, count = np.random.default_rng(8), 500
    albedo, eta, k = rng.random((3, channels)) + np.array([[0.0], [0.3], [1.0]])
    at, wi, wo, u = points(unit(rng, count)), unit(rng, count), unit(rng, count), rng.random((3, count))

    def bsdf(of: slice) -> BSDF:
        metal = RoughConductor(tuple(eta[of]), tuple(k[of]), 0.4)
        blend = Blend(Blend(Lambertian(tuple(albedo[of])), metal, 0.5), RoughDielectric(0.3), 0.2)
        return BlendBSDF([blend], len(eta[of]))

    value, sample = bsdf(slice(None)).f(at, wi, wo), bsdf(slice(None)).sample(at, wo, u)
    assert value.shape == sample.weight.shape == (channels, count)
    for i in range(channels):
        alone = bsdf(slice(i, i + 1))
        np.testing.assert_allclose(value[i], alone.f(at, wi, wo)[0], rtol=1e-14)
        np.testing.assert_allclose(sample.weight[i], alone.sample(at, wo, u).weight[0], rtol=1e-13)


def test_a_blend_with_delta_lobes() -> None:
    """A mirror, glass and metal under a coat of paint, each found as often as the weights say."""
    paint, rng = Lambertian((0.8, 0.3, 0.0)), np.random.default_rng(9)
    mirror, polished = Mirror((0.5, 0.5, 0.5)), Conductor(*GOLD)
    inner = Blend(paint, Dielectric(1.5), 0.25)
    bsdf = BlendBSDF([Blend(inner, Blend(mirror, polished, 0.5), 0.4)], 3)
    at, wo = up(COUNT), viewer(0.6, COUNT)
    sample = bsdf.sample(at, wo, rng.random((3, COUNT)))
    smooth = np.isfinite(sample.pdf)
    assert abs(smooth.mean() - 0.6 * 0.75) < 5 * np.sqrt(0.45 * 0.55 / COUNT)
    # the smooth lobe alone: its share of f over its share of the density
    np.testing.assert_allclose(sample.pdf[smooth], 0.45 * sample.wi[2, smooth] / np.pi, rtol=1e-9)
    np.testing.assert_allclose(
        sample.weight[:, smooth], np.tile([[0.8], [0.3], [0]], smooth.sum()), rtol=1e-9
    )
    np.testing.assert_allclose(bsdf.f(at, at.n, wo)[0], 0.45 * 0.8 / np.pi, rtol=1e-14)
    refracted = sample.wi[2] < 0
    np.testing.assert_allclose(sample.weight[:, refracted], 1 / 2.25, rtol=1e-13)
    F = 0.5 * sum(((0.6 - g) / (0.6 + g)) ** 2 for g in (np.sqrt(1.25 + 0.36), np.sqrt(1.25 + 0.36) / 2.25))
    assert abs(refracted.mean() - 0.6 * 0.25 * (1 - F)) < 5 * np.sqrt(0.15 * 0.85 / COUNT)
    mirrored = (sample.weight[0] == 0.5) & ~smooth
    assert abs(mirrored.mean() - 0.2) < 5 * np.sqrt(0.16 / COUNT)
