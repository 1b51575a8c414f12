"""Any scene: whatever the model accepts renders, and all ways to render the same thing give the same means.

The scenes are drawn at random, with fixed seeds: every shape, material, light and sensor, one among the other. No
truth is known of them, but next event and chance share little more than f, so that an error in a density, a weight
or a side shows as a disagreement between strategies; one in a frame, in a scene that has been moved; one in a
shape, in the same shape told in another way.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from scipy import stats

from reference_tracer import samplers
from reference_tracer.bsdfs.microfacet import RoughConductorBSDF
from reference_tracer.emission import Emitters, NegativeRadianceError
from reference_tracer.emitters.area_lights import EllipsoidEmitter
from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from reference_tracer.random_walk import STRATEGIES, RandomWalk, Strategy, render
from reference_tracer.reflection import bsdf_of
from reference_tracer.samplers import SAMPLERS, Block
from reference_tracer.sensing import Film
from scenes import (
    Affine,
    Disk,
    Ellipsoid,
    IrradianceMeter,
    Mesh,
    Quad,
    RadianceMeter,
    Scene,
    SceneError,
    Shape,
    Sphere,
    Surface,
)
from scenes.transforms import transformed

# ---- whatever the model accepts


def loaded(file: str) -> Any:
    """A module of the tests, by its place in their folder."""
    spec = importlib.util.spec_from_file_location(Path(file).stem, Path(__file__).parents[1] / file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


strategies = loaded("scenes/test_json.py")
random_scene = loaded("reference_tracer/random_scenes.py").random_scene


@settings(
    max_examples=40, derandomize=True, deadline=None, database=None, suppress_health_check=list(HealthCheck)
)
@given(strategies.scenes())
def test_whatever_the_model_accepts_renders(scene: Scene) -> None:
    """By every strategy and sampler; finite, not below zero, without a warning, which these tests make an error."""
    if not isinstance(scene.sensor, RadianceMeter | IrradianceMeter):
        scene = scene.resized(5, 4)
    for strategy in STRATEGIES:
        for sampler in SAMPLERS:
            try:
                image = render(scene, 3, 4, 0, strategy, sampler)
            except NegativeRadianceError:  # the one refusal that the tracer leaves to itself
                continue
            assert np.isfinite(image).all()
            assert image.min() >= 0


REPLICATES, WALKS, BOUNCES = 64, 252, 3
COUNT, CHANCE = 48, 1e-6


class ReplicateFilm(Film):
    """Takes the walks of one block as replicates, each over the whole image."""

    def begin(self, block: Block) -> None:
        self._pixel = np.repeat(np.arange(REPLICATES), WALKS)


def replicates(scene: Scene, strategy: Strategy, seed: int) -> np.ndarray:
    """Means over the image, ``(replicates, bounces, channels)``; bounce 0 is left out."""
    height, width, channels = scene.shape
    assert REPLICATES * WALKS <= samplers.BLOCK
    walk, film = RandomWalk(scene, strategy), ReplicateFilm(BOUNCES, (1, REPLICATES, channels))
    spp = REPLICATES * WALKS // (height * width)
    (block,) = samplers.independent(width, height, spp, seed, walk.dimensions(BOUNCES))
    film.begin(block)
    walk(block, BOUNCES, film)
    return film.mean(WALKS)[1:, 0].transpose(1, 0, 2)


@cache
def straight(seed: int, strategy: Strategy, walks: int) -> np.ndarray:
    """Replicates of a random scene, by the tracer as it is: several tests compare with the same ones."""
    return replicates(random_scene(seed), strategy, walks)


# ---- what is seen often enough


class Seen(NamedTuple):
    """Of which means the noise is known: of each component, ``(bounces, channels)``, and of the total."""

    components: np.ndarray
    total: bool


def often(a: np.ndarray) -> np.ndarray:
    """Whether more than 24 of the 64 replicates carry the mean, by (Σx)² / Σx²."""
    return a.sum(axis=0) ** 2 > 24 * (a**2).sum(axis=0)


def total(a: np.ndarray) -> np.ndarray:
    """All light, bounces and channels together, of each replicate."""
    return a.sum(axis=1).mean(axis=1)


@pytest.fixture(scope="module")
def seen() -> dict[tuple[int, Strategy], Seen]:
    """By scene and strategy, what two runs that are not compared see often enough, both of them.

    Where a few rare bright walks carry a mean, a run that misses them looks well and is wrong by many of its standard
    errors. So the run that is judged can't tell.
    """
    found = {}
    for seed in range(COUNT):
        for i, strategy in enumerate(STRATEGIES):
            pilots = [replicates(random_scene(seed), strategy, 1000 + 6 * seed + 2 * i + k) for k in range(2)]
            components = np.all([often(pilot) for pilot in pilots], axis=0)
            found[seed, strategy] = Seen(components, all(often(total(pilot)) for pilot in pilots))
    return found


# ---- disagreement that chance does not explain


class Pair(NamedTuple):
    """Two ways to render a scene, and what both of them see often enough."""

    a: np.ndarray
    b: np.ndarray
    seen: Seen


def t(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Student's t of the difference of two means over replicates."""
    error = np.sqrt((a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / REPLICATES)
    # some have no noise at all: then rounding is what is left
    return (a.mean(axis=0) - b.mean(axis=0)) / (error + 1e-9 * a.mean(axis=0) + (a.mean(axis=0) == 0))


def expect_agreement(pairs: list[Pair]) -> None:
    """That chance explains all differences of means: the largest of any component, and the totals by chi-square."""
    largest = [np.abs(t(a, b)[seen.components]).max(initial=0) for a, b, seen in pairs]
    count = int(sum(seen.components.sum() for *_, seen in pairs))
    assert count >= 2 * min(COUNT, len(pairs)), f"no power: {count} components are seen often enough"
    allowed = stats.t.isf(CHANCE / count / 2, REPLICATES - 1)
    worst = int(np.argmax(largest))
    if largest[worst] > allowed:
        raise OffError(f"pair {worst} differs by {largest[worst]:.1f} standard errors, allowed {allowed:.1f}")
    totals = np.array([t(total(a), total(b)) for a, b, seen in pairs if seen.total])
    if stats.chi2.sf((totals**2).sum(), len(totals)) < CHANCE:
        raise OffError(
            f"the totals differ by {np.sqrt((totals**2).mean()):.2f} standard errors rms, expected 1"
        )


class OffError(AssertionError):
    """A difference that chance does not explain."""


Known = dict[tuple[int, Strategy], Seen]
Render = Callable[[int, Strategy, int], np.ndarray]


def by_strategy(
    known: Known, one: Strategy, other: Strategy, count: int = COUNT, found: Render = straight
) -> list[Pair]:
    pairs = []
    for i in range(count):
        both = known[i, one], known[i, other]
        seen = Seen(both[0].components & both[1].components, both[0].total and both[1].total)
        pairs.append(Pair(found(i, one, 2 * i), found(i, other, 2 * i + 1), seen))
    return pairs


together = pytest.mark.xdist_group("any scene")


@together
@pytest.mark.parametrize("one", ["bsdf", "nee"])
def test_strategies_agree(seen: Known, one: Strategy) -> None:
    expect_agreement(by_strategy(seen, one, "mis"))


# ---- what sample() says, pdf() and f say too


def random_points(scene: Scene, rng: np.random.Generator) -> tuple[RayCaster, Points, np.ndarray]:
    """Points that random rays meet, and where these came from."""
    d = rng.normal(size=(3, 300))
    d /= np.linalg.norm(d, axis=0)
    cast = RayCaster(scene)
    met = cast(Points.nowhere(rng.uniform(-3, 3, d.shape)), d)
    hit = np.flatnonzero(met.surface != NOWHERE)
    return cast, met[hit], -d[:, hit]


def test_densities_of_emitters() -> None:
    """A direction that next event has chosen has the same density and radiance when chance finds it."""
    kinds: set[str] = set()
    profiles = 0
    for seed in range(300):
        scene, rng = random_scene(seed), np.random.default_rng(seed)
        emitters = Emitters(scene)
        cast, points, _ = random_points(scene, rng)
        if not emitters.dimensions or not len(points):
            continue
        light = emitters.sample(points, rng.random((emitters.dimensions, len(points))))
        found = np.flatnonzero(light.Li.any(axis=0) & ~np.broadcast_to(light.delta, len(points)))
        points, light = points[found], light[found]
        met = cast(points, light.wi)
        free = np.flatnonzero(met.primitive == light.primitive)
        points, light, met = points[free], light[free], met[free]
        np.testing.assert_allclose(emitters.pdf(points, met, light.wi), light.pdf, rtol=1e-6)
        # where a profile makes it depend on the angle, it is as exact as that is where a ray grazes
        profiled = any(s.emission is not None and s.emission.angular_profile for s in scene.surfaces)
        np.testing.assert_allclose(emitters.Le(met, -light.wi), light.Li, rtol=1e-5 if profiled else 1e-12)
        profiles += profiled
        kinds |= {type(scene.surfaces[i].shape).__name__ if i >= 0 else "sky" for i in met.surface}
    assert kinds == {"Quad", "Disk", "Sphere", "Ellipsoid", "Mesh", "sky"}
    assert profiles > 50


def test_densities_of_reflection() -> None:
    """weight = f |cos θ| / pdf, and the density is that of ``pdf``."""
    kinds: set[str] = set()
    for seed in range(300):
        scene, rng = random_scene(seed), np.random.default_rng(seed)
        bsdf = bsdf_of(scene)
        _, points, wo = random_points(scene, rng)
        sample = bsdf.sample(points, wo, rng.random((3, len(points))))
        smooth = np.flatnonzero((sample.pdf > 0) & np.isfinite(sample.pdf))
        points, wi, wo = points[smooth], sample.wi[:, smooth], wo[:, smooth]
        pdf = bsdf.pdf(points, wi, wo)
        np.testing.assert_allclose(pdf, sample.pdf[smooth], rtol=1e-9)
        flux = bsdf.f(points, wi, wo) * np.abs((points.ns * wi).sum(axis=0))
        np.testing.assert_allclose(sample.weight[:, smooth] * pdf, flux, rtol=1e-9)
        kinds |= {type(scene.surfaces[i].material).__name__ for i in points.surface}
    assert kinds == {"Lambertian", "RoughConductor", "RoughDielectric", "Blend"}


# ---- planted faults: the check above finds each, in half of the scenes already


def pdf_scaled(factor: float, owner: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The density that ``sample`` states, and ``pdf`` with it."""
    sample, pdf = owner.sample, owner.pdf

    def wrong(self: Any, *args: Any) -> Any:
        found = sample(self, *args)
        found.pdf = factor * found.pdf
        return found

    monkeypatch.setattr(owner, "sample", wrong)
    monkeypatch.setattr(owner, "pdf", lambda self, *args: factor * pdf(self, *args))


def f_scaled(factor: float, owner: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    f = owner.f
    monkeypatch.setattr(owner, "f", lambda self, *args: factor * f(self, *args))


FAULTS: dict[str, tuple[Callable[..., None], float, Any, Strategy]] = {
    "density of next event": (pdf_scaled, 1.3, Emitters, "bsdf"),
    "density of spheres": (pdf_scaled, 1.5, EllipsoidEmitter, "bsdf"),
    "f of metal is not what its sampling has": (f_scaled, 1.5, RoughConductorBSDF, "nee"),
}


@together
@pytest.mark.parametrize("fault", FAULTS)
def test_planted_faults_are_found(seen: Known, fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plant, factor, owner, one = FAULTS[fault]
    plant(factor, owner, monkeypatch)
    with pytest.raises(OffError):
        expect_agreement(by_strategy(seen, one, "mis", COUNT // 2, straight.__wrapped__))


# ---- the same scene told in another way


def moved(seed: int) -> Scene:
    """Turned, shifted, scaled by 10⁻³ to 10³, half of them mirrored."""
    rng = np.random.default_rng([seed, 1])
    factor = 10 ** rng.choice([-3.0, 3.0, rng.uniform(-3, 3)])
    turn = Affine.rotation(rng.normal(size=3), rng.uniform(0, 360)) @ Affine.scaling(factor)
    mirror = Affine.reflection(rng.normal(size=3)) if seed % 2 else Affine()
    return transformed(
        random_scene(seed), Affine.translation(10 * factor * rng.normal(size=3)) @ mirror @ turn
    )


def retold(scene: Scene) -> Scene:
    """Quads and disks as meshes, spheres as ellipsoids."""
    surfaces = [msgspec.structs.replace(s, shape=another(s)) for s in scene.surfaces]
    return msgspec.structs.replace(scene, surfaces=tuple(surfaces))


def another(surface: Surface) -> Shape:
    shape, sides = surface.shape, 256
    if isinstance(shape, Quad):
        uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        corners = np.array(shape.corner) + uv @ np.array([shape.edge_u, shape.edge_v])
        return Mesh(corners, [(0, 1, 2), (0, 2, 3)], None, uv)
    if isinstance(shape, Disk):  # as a polygon of the same area
        turn = 2 * np.pi * np.arange(sides) / sides
        rim = np.sqrt(turn[1] / np.sin(turn[1])) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        st = np.concatenate([np.zeros((1, 2)), rim])
        corners = np.array(shape.center) + st @ np.array([shape.axis_u, shape.axis_v])
        triangles = [(0, i + 1, (i + 1) % sides + 1) for i in range(sides)]
        return Mesh(corners, triangles, None, (st + 1) / 2)
    if isinstance(shape, Sphere) and not (surface.emission and surface.emission.polar_range):
        x, y, z = (shape.radius * np.eye(3)).tolist()
        return Ellipsoid(shape.center, x, y, z, shape.inward)
    return shape


def pairs_of(known: Known, change: Callable[[int], Scene]) -> list[Pair]:
    pairs = []
    for seed in range(COUNT):
        try:
            other = change(seed)
        except SceneError as error:
            if "texture and a polar range" in error.expected:
                continue  # such a sphere can only be shifted and scaled
            raise
        changed = replicates(other, "mis", 2 * seed + 1)
        pairs.append(Pair(straight(seed, "mis", 2 * seed), changed, known[seed, "mis"]))
    return pairs


@together
@pytest.mark.parametrize("change", [moved, lambda seed: retold(random_scene(seed))], ids=["moved", "retold"])
def test_the_same_scene_in_another_way(seen: Known, change: Callable[[int], Scene]) -> None:
    expect_agreement(pairs_of(seen, change))


@together
def test_a_scene_that_is_not_quite_the_same_is_found(seen: Known) -> None:
    """The power of the above: every surface is 3 % larger, camera and lights are not."""

    def nearly(seed: int) -> Scene:
        scene = random_scene(seed)
        surfaces = tuple(transformed(surface, Affine.scaling(1.03)) for surface in scene.surfaces)
        return msgspec.structs.replace(scene, surfaces=surfaces)

    with pytest.raises(OffError):
        expect_agreement(pairs_of(seen, nearly))
