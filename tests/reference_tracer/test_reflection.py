"""The Lambertian BSDF, surfaces of several materials, and blends."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from reference_tracer.bsdfs.bsdf import BSDF
from reference_tracer.points import NOWHERE, Points
from reference_tracer.reflection import LambertianBSDF, PerSurfaceBSDF, bsdf_of
from scenes import (
    AreaLight,
    Blend,
    Conductor,
    ConstantEnvironment,
    Dielectric,
    Lambertian,
    Material,
    Mirror,
    Pinhole,
    RoughConductor,
    RoughDielectric,
    Scene,
    Sphere,
    Surface,
)
from scenes.library import case

COUNT = 50_000
RED, BLUE = Lambertian((0.8, 0.3, 0.1)), Lambertian((0.1, 0.2, 0.9))


@pytest.fixture(scope="module")
def box() -> Scene:
    return case("cornell-box").scene


@pytest.fixture(scope="module")
def lambertian(box: Scene) -> BSDF:
    return bsdf_of(box)


def scene_of(*materials: Material) -> Scene:
    """Spheres of these materials, one after the other; the first has an emission, since something must."""
    surfaces = [Surface(f"s{i}", Sphere((3.0 * i, 0, 0), 1.0), m) for i, m in enumerate(materials)]
    channels = next((m.channels for m in materials if m.channels is not None), 3)
    surfaces[0] = msgspec.structs.replace(surfaces[0], emission=AreaLight((1.0,) * channels))
    return Scene(tuple(surfaces), Pinhole((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 2, 2))


def unit(rng: np.random.Generator, count: int) -> np.ndarray:
    d = rng.standard_normal((3, count))
    return d / np.linalg.norm(d, axis=0)


def points(surfaces: int, count: int, seed: int = 1, **fields: np.ndarray) -> Points:
    """Points with any normal on any surface: a BSDF asks for no more."""
    rng = np.random.default_rng(seed)
    n = unit(rng, count)
    return Points(
        x=rng.random((3, count)),
        n=n,
        surface=rng.integers(surfaces, size=count),
        ns=fields.get("ns", n),
        uv=fields.get("uv"),
    )


def cosine(at: Points, w: np.ndarray) -> np.ndarray:
    return (at.n * w).sum(axis=0)


def test_a_scene_of_one_type_is_evaluated_without_distribution(lambertian: BSDF) -> None:
    assert type(lambertian) is LambertianBSDF
    assert not lambertian.needs_choice


def test_reciprocity(box: Scene, lambertian: BSDF) -> None:
    at, rng = points(len(box.surfaces), 1000), np.random.default_rng(2)
    wi, wo = unit(rng, 1000), unit(rng, 1000)
    np.testing.assert_array_equal(lambertian.f(at, wi, wo), lambertian.f(at, wo, wi))


def test_value_on_the_front_and_on_the_back(box: Scene, lambertian: BSDF) -> None:
    at, rng = points(len(box.surfaces), 1000), np.random.default_rng(2)
    wi, wo, u = unit(rng, 1000), unit(rng, 1000), rng.random((2, 1000))
    albedo = np.array([surface.material.albedo for surface in box.surfaces])[at.surface].T
    front = (cosine(at, wi) > 0) & (cosine(at, wo) > 0)
    assert 200 < front.sum() < 300
    np.testing.assert_allclose(lambertian.f(at, wi, wo), np.where(front, albedo / np.pi, 0), rtol=1e-15)
    expected = np.where(front, cosine(at, wi) / np.pi, 0)
    np.testing.assert_allclose(lambertian.pdf(at, wi, wo), expected, rtol=1e-14)
    weight = lambertian.sample(at, wo, u).weight
    np.testing.assert_array_equal(weight, np.where(cosine(at, wo) > 0, albedo, 0))


def test_nowhere_is_black(lambertian: BSDF) -> None:
    up = np.array([[0.0, 0.0], [0.0, 0.6], [1.0, 0.8]])
    nowhere = points(1, 2)[np.array([0, 1])]
    nowhere.n = nowhere.ns = np.tile([[0.0], [0.0], [1.0]], 2)
    nowhere.surface = np.full(2, NOWHERE)
    assert not lambertian.f(nowhere, up, up).any()
    assert not lambertian.sample(nowhere, up, np.full((2, 2), 0.3)).weight.any()


def test_energy_is_the_albedo(box: Scene, lambertian: BSDF) -> None:
    """∫ f cos θ dω over the sphere of directions by quadrature in (z, φ), for each surface."""
    nodes, weights = np.polynomial.legendre.leggauss(16)
    z, phi = (grid.ravel() for grid in np.meshgrid((nodes + 1) / 2, 2 * np.pi * np.arange(12) / 12))
    r = np.sqrt(1 - z**2)
    wi = np.stack([r * np.cos(phi), r * np.sin(phi), z])
    areas = np.tile(weights / 2 * 2 * np.pi / 12, 12)
    n, wo = np.tile([[0.0], [0.0], [1.0]], len(z)), np.tile([[0.48], [0.64], [0.6]], len(z))
    for i, surface in enumerate(box.surfaces):
        at = Points(x=np.zeros_like(wi), n=n, surface=np.full(len(z), i), ns=n, uv=None)
        energy = (lambertian.f(at, wi, wo) * z * areas).sum(axis=1)
        np.testing.assert_allclose(energy, surface.material.albedo, rtol=1e-12)
        assert (lambertian.pdf(at, wi, wo) * areas).sum() == pytest.approx(1, rel=1e-12)
        assert not lambertian.single_scattering_loss(i, z).any()


def test_the_weight_is_f_cos_over_pdf(box: Scene, lambertian: BSDF) -> None:
    at, rng = points(len(box.surfaces), 5000), np.random.default_rng(3)
    wo = unit(rng, 5000)
    sample = lambertian.sample(at, wo, rng.random((2, 5000)))
    cos_i, front = cosine(at, sample.wi), cosine(at, wo) > 0
    assert cos_i.min() > 0
    np.testing.assert_allclose(np.linalg.norm(sample.wi, axis=0), 1, rtol=1e-15)
    np.testing.assert_allclose(sample.pdf, np.where(front, cos_i / np.pi, 0), rtol=1e-10)
    f_cos = lambertian.f(at, sample.wi, wo) * cos_i
    np.testing.assert_allclose(sample.weight * sample.pdf, f_cos, rtol=1e-10)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.6, -0.48, 0.64), (-1.0, 0.0, 0.0)])
def test_sampling_follows_the_density(
    lambertian: BSDF, normal: tuple, follows: Callable[[np.ndarray, np.ndarray], bool]
) -> None:
    """Counts over 12 × 12 cells of equal z and azimuth about the normal, in a frame made here."""
    n = np.tile(np.array(normal)[:, None], COUNT)
    at = Points(x=np.zeros((3, COUNT)), n=n, surface=np.zeros(COUNT, dtype=int), ns=n, uv=None)
    wi = lambertian.sample(at, n, np.random.default_rng(5).random((2, COUNT))).wi
    across = np.cross(normal, [0.36, 0.48, 0.8])
    across /= np.linalg.norm(across)
    azimuth = np.arctan2(np.cross(normal, across) @ wi, across @ wi)
    edges = np.linspace(0, 1, 13)
    counts = np.histogram2d(normal @ wi, azimuth, bins=(edges, np.linspace(-np.pi, np.pi, 13)))[0]
    assert counts.sum() == COUNT
    cells = np.repeat(np.diff(edges**2)[:, None] / 12, 12, axis=1)  # ∫ z/π dz dφ
    assert follows(counts, cells)
    assert not follows(counts, np.full_like(cells, 1 / cells.size))  # uniform on the hemisphere


def test_no_number_makes_a_direction_that_is_none(lambertian: BSDF) -> None:
    """u = 0 is the pole of the sphere that touches the surface, for a normal along −z the point x itself."""
    n = np.array([[0.0], [0.0], [-1.0]])
    at = Points(x=np.zeros((3, 1)), n=n, surface=np.zeros(1, dtype=int), ns=n, uv=None)
    sample = lambertian.sample(at, n, np.zeros((2, 1)))
    assert np.isfinite(sample.wi).all()
    assert not sample.weight.any()
    assert not sample.pdf.any()


def test_shading_normals_shade_and_true_normals_say_which_side(lambertian: BSDF) -> None:
    """Cosines are those of ns; a direction on the front of the one and on the back of the other is black."""
    at, rng = points(18, 4000), np.random.default_rng(6)
    at.ns = at.n + 0.8 * unit(rng, 4000)
    at.ns /= np.linalg.norm(at.ns, axis=0)
    wi, wo = unit(rng, 4000), unit(rng, 4000)
    shaded = (at.ns * wi).sum(axis=0)
    front = (shaded > 0) & ((at.ns * wo).sum(axis=0) > 0) & (cosine(at, wi) > 0) & (cosine(at, wo) > 0)
    np.testing.assert_array_equal((lambertian.f(at, wi, wo) > 0).any(axis=0), front)
    np.testing.assert_allclose(lambertian.pdf(at, wi, wo), np.where(front, shaded / np.pi, 0), rtol=1e-12)
    sample = lambertian.sample(at, wo, rng.random((2, 4000)))
    below = cosine(at, sample.wi) <= 0
    assert 20 < below.sum() < 1000
    assert not sample.weight[:, below].any()
    f_cos = lambertian.f(at, sample.wi, wo) * (at.ns * sample.wi).sum(axis=0)
    np.testing.assert_allclose(sample.weight * sample.pdf, f_cos, rtol=1e-9, atol=1e-15)


def test_a_black_surface_reflects_nothing(box: Scene) -> None:
    black = [msgspec.structs.replace(surface, material=Lambertian((0.0,) * 3)) for surface in box.surfaces]
    bsdf, at = bsdf_of(Scene(tuple(black), box.sensor)), points(18, 100)
    sample = bsdf.sample(at, at.n, np.random.default_rng(1).random((2, 100)))
    assert not bsdf.f(at, sample.wi, at.n).any()
    assert not sample.weight.any()


def test_a_blend_of_two_lambertians_is_a_lambertian() -> None:
    """Also in a scene of several types, nested, and where the weight leaves one of the two nothing."""
    inner = Blend(RED, BLUE, 0.25)
    materials = (RED, Blend(RED, BLUE, 0.0), Blend(RED, BLUE, 1.0), inner, Blend(BLUE, inner, 0.6))
    bsdf = bsdf_of(scene_of(*materials))
    assert isinstance(bsdf, PerSurfaceBSDF)
    assert bsdf.needs_choice
    red, blue = np.array(RED.albedo), np.array(BLUE.albedo)
    shares = np.array([0, 0, 1, 0.25, 0.4 + 0.6 * 0.25])
    albedos = (1 - shares) * red[:, None] + shares * blue[:, None]
    at, rng = points(5, 2000), np.random.default_rng(7)
    wi, wo = unit(rng, 2000), unit(rng, 2000)
    front = (cosine(at, wi) > 0) & (cosine(at, wo) > 0)
    expected = np.where(front, albedos[:, at.surface] / np.pi, 0)
    np.testing.assert_allclose(bsdf.f(at, wi, wo), expected, rtol=1e-14)
    np.testing.assert_allclose(bsdf.pdf(at, wi, wo), np.where(front, cosine(at, wi) / np.pi, 0), rtol=1e-13)
    sample, seen = bsdf.sample(at, wo, rng.random((3, 2000))), cosine(at, wo) > 0
    np.testing.assert_allclose(sample.weight, np.where(seen, albedos[:, at.surface], 0), rtol=1e-12)
    pdf = np.where(seen, cosine(at, sample.wi) / np.pi, 0)
    np.testing.assert_allclose(sample.pdf, pdf, rtol=1e-9)
    assert not bsdf.single_scattering_loss(4, np.array([0.1, 1.0])).any()


def test_a_number_that_chooses_a_lobe_can_be_used_again() -> None:
    """The last numbers below the weight and below 1 leave a rest below 1."""
    bsdf = bsdf_of(scene_of(Blend(RED, Blend(RED, BLUE, 0.3), 0.7)))
    below = np.nextafter([0.7, 1.0], 0)
    at = points(1, 2)
    weight = bsdf.sample(at, at.n, np.stack([np.full(2, 0.3), np.full(2, 0.2), below])).weight
    blue = 0.7 * 0.3
    expected = (1 - blue) * np.array(RED.albedo) + blue * np.array(BLUE.albedo)
    np.testing.assert_allclose(weight, np.tile(expected[:, None], 2), rtol=1e-14)


def test_each_surface_reflects_as_its_own_material_does() -> None:
    """Seven types in one scene, one of them twice: the same numbers as each type alone, NOWHERE black."""
    gold = ((0.2, 0.4, 1.4), (3.9, 2.4, 1.8))
    mirror, glass, frosted = Mirror((0.9, 0.8, 0.7)), Dielectric(), RoughDielectric(0.3)
    materials = (RED, mirror, glass, Conductor(*gold), RoughConductor(*gold, 0.4), frosted)
    materials += (Blend(RED, Blend(mirror, frosted, 0.3), 0.5), BLUE)
    bsdf = bsdf_of(scene_of(*materials))
    assert bsdf.needs_choice
    at, rng = points(len(materials) + 1, 4000), np.random.default_rng(8)
    at.surface = np.where(at.surface == len(materials), NOWHERE, at.surface)
    wi, wo, u = unit(rng, 4000), unit(rng, 4000), rng.random((3, 4000))
    f, pdf, sample = bsdf.f(at, wi, wo), bsdf.pdf(at, wi, wo), bsdf.sample(at, wo, u)
    for i, material in enumerate(materials):
        lanes = np.flatnonzero(at.surface == i)
        here = at[lanes]
        here.surface = np.zeros(len(lanes), dtype=int)
        alone = bsdf_of(scene_of(material))
        assert not isinstance(alone, PerSurfaceBSDF)
        np.testing.assert_array_equal(f[:, lanes], alone.f(here, wi[:, lanes], wo[:, lanes]))
        np.testing.assert_array_equal(pdf[lanes], alone.pdf(here, wi[:, lanes], wo[:, lanes]))
        expected = alone.sample(here, wo[:, lanes], u[:, lanes])
        np.testing.assert_array_equal(sample.wi[:, lanes], expected.wi)
        np.testing.assert_array_equal(sample.weight[:, lanes], expected.weight)
        np.testing.assert_array_equal(sample.pdf[lanes], expected.pdf)
        cosines = np.array([0.3, 0.9])
        loss = bsdf.single_scattering_loss(i, cosines)
        np.testing.assert_array_equal(loss, alone.single_scattering_loss(0, cosines))
    nowhere = at.surface == NOWHERE
    assert nowhere.sum() > 100
    assert not f[:, nowhere].any()
    assert not sample.weight[:, nowhere].any()
    assert not sample.pdf[nowhere].any()


def test_a_scene_without_surfaces_reflects_nothing() -> None:
    nothing = Scene((), scene_of(RED).sensor, (ConstantEnvironment((1.0, 1.0, 1.0)),))
    bsdf, at = bsdf_of(nothing), points(1, 10)
    at.surface = np.full(10, NOWHERE)
    assert not bsdf.needs_choice
    assert bsdf.f(at, at.n, at.n).shape == (3, 10)
    assert not bsdf.f(at, at.n, at.n).any()
    assert not bsdf.pdf(at, at.n, at.n).any()
    assert not bsdf.sample(at, at.n, np.full((2, 10), 0.4)).weight.any()


@pytest.mark.parametrize(
    "material", [RoughConductor((1.5,), (2.0,), 0.3), RoughDielectric(0.3), Lambertian((0.4,))]
)
def test_a_blend_of_a_material_with_itself_is_that_material(material: Material) -> None:
    blend = Blend(material, Blend(material, material, 0.8), 0.3)
    grey = Lambertian((0.5,))
    blended, alone = bsdf_of(scene_of(grey, blend)), bsdf_of(scene_of(grey, material))
    at, rng = points(1, 1000), np.random.default_rng(9)
    at.surface = np.ones(1000, dtype=int)
    wi, wo = unit(rng, 1000), unit(rng, 1000)
    np.testing.assert_allclose(blended.f(at, wi, wo), alone.f(at, wi, wo), rtol=1e-13)
    np.testing.assert_allclose(blended.pdf(at, wi, wo), alone.pdf(at, wi, wo), rtol=1e-13)
    sample = blended.sample(at, wo, rng.random((3, 1000)))
    kept = sample.pdf > 0
    assert kept.sum() > 400
    np.testing.assert_allclose(sample.pdf[kept], alone.pdf(at, sample.wi, wo)[kept], rtol=1e-7)
    cosines = np.array([0.2, 0.7])
    loss = alone.single_scattering_loss(1, cosines)
    np.testing.assert_allclose(blended.single_scattering_loss(1, cosines), loss, rtol=1e-13)
