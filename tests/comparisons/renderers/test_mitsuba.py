"""The adapter contributes nothing: each of its conversions is tried on a scene that would show it wrong."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
import pytest

from comparisons.renderers import Unsupported
from comparisons.renderers.mitsuba import MitsubaRenderer
from reference_tracer.random_walk import render
from scenes import (
    AreaLight,
    Blend,
    Checkerboard,
    Conductor,
    Dielectric,
    DirectionalLight,
    Disk,
    Ellipsoid,
    EnvironmentMap,
    Image,
    IrradianceMeter,
    Lambertian,
    Material,
    Mesh,
    Mirror,
    Orthographic,
    Pinhole,
    PointLight,
    PolarRange,
    Quad,
    RoughConductor,
    RoughDielectric,
    Scene,
    Sphere,
    SphericalHarmonicsEnvironment,
    SpotLight,
    Surface,
    ThinLens,
    library,
)

GREY = Lambertian((0.5, 0.5, 0.5))
FLAT = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
METAL = ((1.0, 1.0, 1.0), (2.0, 2.0, 2.0))
CHECKS = Lambertian(Checkerboard((0.1, 0.2, 0.3), (0.4, 0.5, 0.6)))


def lamp(
    corner: tuple[float, float, float], u: tuple[float, float, float], v: tuple[float, float, float]
) -> Surface:
    return Surface("lamp", Quad(corner, u, v), GREY, AreaLight((1.0, 2.0, 4.0)))


def scene(*surfaces: Surface, width: int = 24, height: int = 24, **sensor: object) -> Scene:
    options = {"origin": (0.3, 0.2, 3.0), "target": (0.0, 0.1, 0.0), "up": (0.1, 1.0, 0.0), "fov": 50.0}
    return Scene(surfaces, Pinhole(**(options | sensor), width=width, height=height))  # type: ignore[arg-type]


def seen_by(camera: type, view: Scene, **options: float) -> Scene:
    """The same scene through another camera from the same place."""
    pinhole = view.sensor
    assert isinstance(pinhole, Pinhole)
    shared = {f: getattr(pinhole, f) for f in camera.__struct_fields__ if hasattr(pinhole, f)}
    return msgspec.structs.replace(view, sensor=camera(**shared | options))


def leaning_lamp() -> Surface:
    return lamp((0.1, 0.2, 0.0), (0.9, 0.1, 0.0), (-0.1, 0.9, 0.0))


def zoned_sphere(inward: bool, axis: tuple[float, float, float], low: float, high: float) -> Surface:
    light = AreaLight((1.0, 2.0, 4.0), PolarRange(low, high, axis))
    return Surface("sphere", Sphere((0.2, -0.1, 0.0), 0.8, inward), GREY, light)


ASYMMETRIC: dict[str, Callable[[], Scene]] = {
    "camera, one lamp off every axis": lambda: scene(
        lamp((0.1, 0.2, 0.0), (0.9, 0.1, 0.0), (-0.04, 0.36, 0.1))
    ),
    "wide image": lambda: scene(
        lamp((0.1, 0.2, 0.0), (0.9, 0.1, 0.0), (-0.1, 0.9, 0.0)), width=40, height=16
    ),
    "tall image": lambda: scene(
        lamp((0.1, 0.2, 0.0), (0.9, 0.1, 0.0), (-0.1, 0.9, 0.0)), width=16, height=40
    ),
    "a lamp seen from behind is black": lambda: scene(
        lamp((0.1, 0.2, 0.0), (0.0, 0.4, 0.0), (0.9, 0.0, 0.0)),
        Surface(
            "other",
            Quad((-1.0, -1.0, -1.0), (0.8, 0.0, 0.0), (0.0, 0.8, 0.0)),
            GREY,
            AreaLight((1.0, 1.0, 1.0)),
        ),
    ),
    "zone of a sphere from outside": lambda: scene(zoned_sphere(False, (0.3, 0.4, 0.8), 20.0, 60.0)),
    "zone of a sphere from inside": lambda: scene(
        zoned_sphere(True, (0.2, 0.5, -0.8), 0.0, 45.0), origin=(0.3, 0.1, 0.4), target=(0.1, -0.1, -0.5)
    ),
    "the whole sphere from outside": lambda: scene(
        Surface("sphere", Sphere((0.2, -0.1, 0.0), 0.8), GREY, AreaLight((1.0, 2.0, 4.0)))
    ),
    "orthographic": lambda: seen_by(Orthographic, scene(leaning_lamp()), extent=2.5),
    "wide orthographic": lambda: seen_by(
        Orthographic, scene(leaning_lamp(), width=40, height=16), extent=1.9
    ),
    "tall orthographic": lambda: seen_by(
        Orthographic, scene(leaning_lamp(), width=16, height=40), extent=1.9
    ),
    "thin lens, in focus": lambda: seen_by(
        ThinLens, scene(leaning_lamp()), aperture_radius=0.3, focus_distance=3.0
    ),
    "thin lens, focus in front": lambda: seen_by(
        ThinLens, scene(leaning_lamp(), width=30), aperture_radius=0.2, focus_distance=2.0
    ),
    "thin lens, focus behind": lambda: seen_by(
        ThinLens, scene(leaning_lamp(), height=30), aperture_radius=0.4, focus_distance=6.0
    ),
    "large scene": lambda: scene(
        lamp((0.1e6, 0.2e6, 0.0), (0.9e6, 0.1e6, 0.0), (-0.1e6, 0.9e6, 0.0)),
        origin=(0.3e6, 0.2e6, 3e6),
        target=(0.0, 0.1e6, 0.0),
    ),
    "large orthographic scene": lambda: seen_by(
        Orthographic,
        scene(
            lamp((0.1e6, 0.2e6, 0.0), (0.9e6, 0.1e6, 0.0), (-0.1e6, 0.9e6, 0.0)),
            origin=(0.3e6, 0.2e6, 3e6),
            target=(0.0, 0.1e6, 0.0),
        ),
        extent=2.5e6,
    ),
    "small scene": lambda: scene(
        lamp((0.1e-3, 0.2e-3, 0.0), (0.9e-3, 0.1e-3, 0.0), (-0.1e-3, 0.9e-3, 0.0)),
        origin=(0.3e-3, 0.2e-3, 3e-3),
        target=(0.0, 0.1e-3, 0.0),
    ),
}


@pytest.mark.parametrize("name", ASYMMETRIC)
def test_emission_lands_in_the_same_pixels(mitsuba: MitsubaRenderer, name: str) -> None:
    """Bounce 0 without a common random number: pixels inside and outside agree exactly, edges statistically."""
    view = ASYMMETRIC[name]()
    spp = 400
    ours, theirs = render(view, 0, spp, 1)[0], mitsuba.render(view, [0], spp, 1)[0]
    assert 0 < (ours > 0).mean() < 1
    full = ours.max(axis=(0, 1))
    np.testing.assert_allclose(theirs.max(axis=(0, 1)), full, rtol=1e-6)
    # a pixel's coverage is a binomial share of 400 samples: two of them differ by less than 6 standard errors
    assert (np.abs(theirs - ours) / full).max() < 6 * np.sqrt(2 * 0.25 / spp)
    for wrong in (ours[::-1], ours[:, ::-1], np.roll(ours, 1, axis=0), np.roll(ours, 1, axis=1)):
        assert (np.abs(wrong - ours) / full).max() > 6 * np.sqrt(2 * 0.25 / spp)


def test_depths_are_coupled_so_that_no_term_is_negative(mitsuba: MitsubaRenderer) -> None:
    images = mitsuba.render(library.case("cornell-box").scene.resized(16, 16), range(6), 32, 3)
    assert images.min() >= -1e-6
    assert (images[1:].mean(axis=(1, 2)) > 0).all()


def test_depths_are_coupled_with_every_plugin(mitsuba: MitsubaRenderer) -> None:
    """No term is negative, however a material draws its numbers, and each has light; a thin lens looks on."""
    rough = {"alpha": 0.3, "shadowing": "separable"}
    materials: list[Material] = [
        CHECKS,
        Mirror((0.9, 0.8, 0.7)),
        Conductor(*METAL),
        Dielectric(),
        RoughConductor(*METAL, **rough),
        RoughDielectric(**rough),
        Blend(GREY, Blend(CHECKS, RoughConductor(*METAL, **rough), 0.4), 0.6),
        Blend(Mirror((0.9, 0.8, 0.7)), Dielectric(), 0.4),
    ]
    balls = [
        Surface(f"ball {i}", Sphere((0.9 * i - 2.7, 0.1 * i, 0.0), 0.5), material)
        for i, material in enumerate(materials)
    ]
    floor = Surface("floor", Quad((-5.0, -1.0, 5.0), (10.0, 0.0, 0.0), (0.0, 0.0, -10.0)), CHECKS)
    mesh = Mesh(((-3.0, 2.0, -2.0), (3.0, 2.0, -2.0), (0.0, 2.5, 2.0)), ((0, 1, 2),))
    lights = (
        PointLight((0.0, 3.0, 2.0), (3.0, 2.0, 1.0)),
        SpotLight((2.0, 3.0, 2.0), (-0.3, -1.0, -0.3), (3.0, 2.0, 1.0), 60.0, 20.0),
        DirectionalLight((0.1, -1.0, -0.5), (0.3, 0.2, 0.1)),
        EnvironmentMap(Image((((0.1, 0.2, 0.3), (0.4, 0.5, 0.6)),))),
    )
    view = scene(
        *balls,
        floor,
        Surface("mesh", mesh, GREY, AreaLight((1.0, 2.0, 4.0))),
        origin=(0.0, 1.0, 6.0),
        target=(0.0, 0.0, 0.0),
    )
    view = msgspec.structs.replace(
        seen_by(ThinLens, view, aperture_radius=0.05, focus_distance=6.0), lights=lights
    )
    images = mitsuba.render(view, range(6), 16, 3)
    assert images.min() >= -1e-6 * images.max()
    assert (images.mean(axis=(1, 2)) > 0).all()

    # and they are the terms that the reference tracer has: 9 means of 24 renders each
    def means(images: Callable[[int], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        found = np.array([images(seed)[:3].mean(axis=(1, 2)) for seed in range(24)])
        return found.mean(axis=0), found.std(axis=0, ddof=1) / np.sqrt(24)

    theirs, their_error = means(lambda seed: mitsuba.render(view, range(3), 16, seed))
    ours, our_error = means(lambda seed: render(view, 2, 16, seed))
    error = np.hypot(their_error, our_error)
    assert (error < 0.03 * ours).all()
    np.testing.assert_array_less(np.abs(theirs - ours), 4.5 * error)  # by chance once in 2,000 sets of seeds


def test_each_row_is_one_power_of_t(mitsuba: MitsubaRenderer) -> None:
    """Powers of the albedo number the bounces: halving it divides bounce k by 2ᵏ, exactly in a furnace."""
    walls = library.case("furnace-box").scene.resized(8, 8)
    images = mitsuba.render(walls, range(5), 256, 0).mean(axis=(1, 2, 3))
    np.testing.assert_allclose(images, 0.5 ** np.arange(5), rtol=0.02)


def test_more_bounces_do_not_change_the_first(mitsuba: MitsubaRenderer) -> None:
    view = library.case("cornell-box").scene.resized(8, 8)
    np.testing.assert_allclose(
        mitsuba.render(view, range(5), 4, 7)[:3], mitsuba.render(view, range(3), 4, 7), atol=1e-6
    )


def test_the_same_seed_gives_the_same_image() -> None:
    """Also in another process: the order of 24 emitters does not depend on where they lie in memory."""
    view = library.case("furnace-cornell").scene.resized(6, 6)
    first, second = (MitsubaRenderer("scalar_rgb").render(view, [1], 2, 7) for _ in range(2))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize(
    ("view", "feature"),
    [
        (lambda: scene(zoned_sphere(False, (0.0, 0.0, 1.0), 0.0, 10.0001)), "no texture has borders there"),
        (
            lambda: scene(Surface("s", Sphere((0.0, 0.0, 0.0), 1.0), Lambertian((0.5,)), AreaLight((1.0,)))),
            "1 channels",
        ),
    ],
)
def test_what_it_can_t_express_is_named(
    mitsuba: MitsubaRenderer, view: Callable[[], Scene], feature: str
) -> None:
    with pytest.raises(Unsupported, match=feature):
        mitsuba.render(view(), [0, 1], 1, 0)


TILTED = AreaLight((1.0, 2.0, 4.0), PolarRange(0.0, 90.0, (0.0, 1.0, 0.0)))
MISSING: dict[str, dict[str, Any]] = {
    "ellipsoid shape": {"shape": Ellipsoid(*FLAT, (0.0, 0.0, 1.0))},
    "radii that are nearly parallel": {"shape": Disk(FLAT[0], FLAT[1], (1.0, 0.005, 0.0))},
    "texture on a disk": {"shape": Disk(*FLAT), "material": CHECKS},
    "a texture on a disk": {"shape": Disk(*FLAT), "material": Blend(GREY, CHECKS, 0.5)},
    "about an axis other than z": {
        "shape": Sphere(FLAT[0], 1.0),
        "material": CHECKS,
        "emission": TILTED,
    },
    "emission from both sides": {"emission": AreaLight((1.0, 2.0, 4.0)), "two_sided": True},
    "angular profile": {"emission": AreaLight((1.0, 2.0, 4.0), None, ((1, 1, 1), (2, 2, 2)))},
    "correlated shadowing": {"material": RoughConductor(*METAL, 0.1)},
    "a correlated shadowing|correlated": {"material": Blend(GREY, RoughDielectric(0.1), 0.5)},
    "spherical_harmonics light": {"lights": (SphericalHarmonicsEnvironment(((1.0, 1.0, 1.0),)),)},
    "irradiance_meter sensor": {"sensor": IrradianceMeter((0.0, 0.0, 5.0), (0.0, 0.0, -1.0))},
}


@pytest.mark.parametrize("feature", MISSING)
def test_what_mitsuba_does_not_have_is_named(mitsuba: MitsubaRenderer, feature: str) -> None:
    """Left out or put as something else it would be a wrong image, and Mitsuba would get the blame."""
    view = scene(lamp((2.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), Surface("new", Quad(*FLAT), GREY))
    assert mitsuba.render(view, [0], 1, 0).shape == (1, 24, 24, 3)
    on_surface = {k: v for k, v in MISSING[feature].items() if k in Surface.__struct_fields__}
    on_scene = {k: v for k, v in MISSING[feature].items() if k in Scene.__struct_fields__}
    surfaces = (view.surfaces[0], msgspec.structs.replace(view.surfaces[1], **on_surface))
    changed = msgspec.structs.replace(view, surfaces=surfaces, **on_scene)
    with pytest.raises(Unsupported, match=feature):
        mitsuba.render(changed, [0], 1, 0)


class Consecutive:
    """What draws seeds one after the other, as one would at first."""

    def __init__(self, seed: int) -> None:
        self._first = 5000 + seed

    def integers(self, high: int, size: int) -> np.ndarray:
        return np.arange(self._first, self._first + size)


def test_samples_form_no_lattice_over_the_image(
    mitsuba: MitsubaRenderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The largest peak in the spectrum of the errors of TE: noise alone reaches 16 once in 4,000 images."""
    box = library.case("cornell-box")
    truth = box.answer.truth(box.scene, 1)
    assert truth is not None

    def peak() -> float:
        images = np.array([mitsuba.render(box.scene, [1], 1, seed)[0, ..., 1] for seed in range(512)])
        with np.errstate(divide="ignore", invalid="ignore"):
            z = (images.mean(axis=0) - truth.mean[1, ..., 1]) / images.std(axis=0)
        z = np.clip(np.nan_to_num(z * np.sqrt(512), posinf=0, neginf=0), -4, 4)
        power = np.abs(np.fft.fft2(z - z.mean())) ** 2
        return float(power.max() / power.mean())

    assert peak() < 16
    monkeypatch.setattr(np.random, "default_rng", Consecutive)
    assert peak() > 16


def test_replicates_are_independent(mitsuba: MitsubaRenderer, monkeypatch: pytest.MonkeyPatch) -> None:
    """The means of 256 images with consecutive seeds: |autocorrelation| < 0.3 but once in 10⁶, at lags 1 to 4."""
    sphere = library.case("integrating-sphere").scene

    def autocorrelation() -> float:
        means = [mitsuba.render(sphere, [1], 1, seed).mean() for seed in range(256)]
        z = np.asarray(means) - np.mean(means)
        return max(abs(float(z[lag:] @ z[:-lag] / (z @ z))) for lag in range(1, 5))

    assert autocorrelation() < 0.3
    monkeypatch.setattr(np.random, "default_rng", Consecutive)
    assert autocorrelation() > 0.3
