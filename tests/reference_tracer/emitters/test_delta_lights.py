"""Point, spot and directional lights: what arrives, and their power by quadrature."""

from __future__ import annotations

import numpy as np
import pytest

from reference_tracer.emitters.delta_lights import DeltaEmitter, delta_lights
from reference_tracer.emission import Emitters
from reference_tracer.points import NOWHERE, Points
from scenes import DeltaLight, DirectionalLight, Pinhole, PointLight, Scene, SpotLight

CAMERA = Pinhole((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 4, 4)
I = (2.0, 3.0, 7.0)  # noqa: E741  intensity
DOWN = (0.0, 0.0, -1.0)
POINT, SUN = PointLight((1.0, 2.0, 3.0), I), DirectionalLight((0.6, 0.0, -0.8), I)


def at(*x: tuple) -> Points:
    return Points.nowhere(np.array(x, dtype=float).T)


def spot(beam: float, cutoff: float) -> SpotLight:
    return SpotLight((0.0, 0.0, 1.0), DOWN, I, cutoff, beam)


def test_a_point_light() -> None:
    """The irradiance on a plane that faces it is I / d²."""
    reference = at((1, 2, 0), (1, -1, -1), (1e9, 2, 3))
    wi, distance, Li = DeltaEmitter(POINT, 1.0).incident(reference)
    np.testing.assert_allclose(wi.T, [(0, 0, 1), (0, 0.6, 0.8), (-1, 0, 0)], atol=1e-15)
    np.testing.assert_allclose(distance, [3, 5, 1e9 - 1])
    np.testing.assert_allclose(Li, np.outer(I, 1 / distance**2), rtol=1e-15)


def test_at_the_place_of_the_light_itself_there_is_none() -> None:
    for light in (POINT, SpotLight(POINT.position, DOWN, I, 40.0, 20.0)):
        wi, distance, Li = DeltaEmitter(light, 1.0).incident(at(POINT.position))
        assert not Li.any()
        assert np.isfinite(wi).all()
        assert np.isfinite(distance).all()


@pytest.mark.parametrize(
    ("degrees", "share"),
    [(0, 1), (19.999, 1), (25, 0.75), (30, 0.5), (39.9999, 2.5e-6 * 2), (40.001, 0), (90, 0), (180, 0)],
)
def test_a_spot_falls_linearly_from_beam_to_cutoff(degrees: float, share: float) -> None:
    angle, d = np.radians(degrees), 2.5
    x = (d * np.sin(angle), 0.0, 1 - d * np.cos(angle))
    wi, distance, Li = DeltaEmitter(spot(20.0, 40.0), 1.0).incident(at(x))
    np.testing.assert_allclose(Li[:, 0], np.array(I) * share / d**2, rtol=1e-7)
    np.testing.assert_allclose(wi[:, 0] * distance, np.array([0, 0, 1]) - x, atol=1e-12)


def test_a_spot_with_a_sharp_edge_and_a_very_narrow_one() -> None:
    sharp = DeltaEmitter(spot(30.0, 30.0), 1.0)
    below, above = ((np.sin(a), 0.0, 1 - np.cos(a)) for a in np.radians([29.999, 30.001]))
    np.testing.assert_allclose(sharp.incident(at(below, above))[2], np.outer(I, [1, 0]), rtol=1e-12)
    narrow = DeltaEmitter(spot(0.0, 1e-6), 1.0)  # half way to the edge, where an arccosine has no digits
    Li = narrow.incident(at((np.radians(0.5e-6), 0.0, 0.0)))[2]
    np.testing.assert_allclose(Li[:, 0], np.array(I) / 2, rtol=1e-7)


def test_a_directional_light_is_the_same_everywhere() -> None:
    wi, distance, Li = DeltaEmitter(SUN, 1.0).incident(at((0, 0, 0), (5, -1e9, 3)))
    np.testing.assert_array_equal(wi, np.tile([[-0.6], [0.0], [0.8]], 2))
    assert np.isinf(distance).all()
    np.testing.assert_array_equal(Li, np.tile(np.array(I)[:, None], 2))


@pytest.mark.parametrize(
    ("beam", "cutoff"), [(0, 180), (20, 40), (30, 30), (30, 30.000001), (0, 90), (179, 180)]
)
def test_the_power_of_a_spot(beam: float, cutoff: float) -> None:
    """∫ I dω by quadrature over the angle, of what arrives on the unit sphere around the light."""
    light, power = spot(beam, cutoff), 0.0
    nodes, weights = np.polynomial.legendre.leggauss(40)
    for low, high in np.radians([(0, beam), (beam, cutoff)]):
        theta = low + (high - low) * (nodes + 1) / 2
        x = np.stack([np.sin(theta), 0 * theta, 1 - np.cos(theta)])
        Li = DeltaEmitter(light, 1.0).incident(Points.nowhere(x))[2].mean(axis=0)
        power += float(weights @ (Li * np.sin(theta))) * (high - low) / 2 * 2 * np.pi
    assert DeltaEmitter(light, 1.0).power == pytest.approx(power, rel=1e-9)


def test_the_power_of_the_others() -> None:
    assert DeltaEmitter(POINT, 1.0).power == pytest.approx(4 * np.pi * 4)
    assert DeltaEmitter(SUN, 3.0).power == pytest.approx(np.pi * 9 * 4)


@pytest.mark.parametrize("light", [POINT, spot(20, 40), SUN], ids=lambda light: type(light).__name__)
def test_next_event_has_what_arrives(light: DeltaLight) -> None:
    """f cos Li / pdf needs no more: the only light has pdf 1, and takes no part in weights."""
    scene, reference = Scene((), CAMERA, (light,)), at((0, 0, 0), (0.1, 0.2, -1))
    for emitters in (Emitters(scene), Emitters(scene, delta_only=True)):
        sample = emitters.sample(reference, np.zeros((emitters.dimensions, 2)))
        wi, distance, Li = delta_lights(scene, 1.0)[0].incident(reference)
        for found, expected in ((sample.wi, wi), (sample.distance, distance), (sample.Li, Li)):
            np.testing.assert_array_equal(found, expected)
        np.testing.assert_array_equal(sample.pdf, 1)
        assert np.all(sample.delta)
        assert (sample.primitive == NOWHERE).all()
        assert not emitters.pdf(reference, reference, wi).any()
        assert not emitters.Le(reference, -wi).any()


def test_the_delta_lights_of_a_scene_come_in_its_order() -> None:
    found = delta_lights(Scene((), CAMERA, (SUN, spot(20, 40), POINT)), 2.0)
    assert [emitter.light for emitter in found] == [SUN, spot(20, 40), POINT]
