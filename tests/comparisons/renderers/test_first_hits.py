"""G by itself, of every scene in the library: both renderers against the closed forms."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from comparisons.relations import RELATIONS
from comparisons.relations.relation import Exact, NotApplicableError, Witness
from comparisons.renderers import Hits, Images, Unsupported
from comparisons.renderers.process import RendererProcess
from comparisons.renderers.reference import ReferenceRenderer
from scenes import (
    IrradianceMeter,
    Lambertian,
    Orthographic,
    PointLight,
    Quad,
    RadianceMeter,
    Scene,
    Sphere,
    Surface,
    ThinLens,
    library,
)
from scenes.features import features


class Reference:
    def render(self, *_: object) -> Images:
        raise AssertionError

    def first_hits(self, scene: Scene) -> Hits:
        return ReferenceRenderer("mis").first_hits(scene)

    def restart(self) -> None:
        raise AssertionError


class Mitsuba(Reference):
    def __init__(self, process: RendererProcess) -> None:
        self._process = process

    def first_hits(self, scene: Scene) -> Hits:
        return self._process.first_hits(scene, timeout=60)


@pytest.fixture(scope="module")
def mitsuba() -> Iterator[Witness]:
    with RendererProcess("mitsuba:scalar_rgb") as process:
        yield Mitsuba(process)


def small(name: str) -> Scene:
    scene = library.case(name).scene
    return scene if scene.shape[:2] == (1, 1) else scene.resized(12, 12)


def told(scene: Scene, witness: Witness) -> str:
    [claim] = RELATIONS["first-hits"].claims(scene, 0, "")
    assert isinstance(claim, Exact)
    found = claim.look(witness)
    return f"{found.verdict}: {found.message}"


@pytest.mark.parametrize("name", library.CASES)
def test_every_scene_of_the_library(name: str, mitsuba: Witness) -> None:
    scene = small(name)
    if isinstance(scene.sensor, IrradianceMeter):
        with pytest.raises(NotApplicableError):
            told(scene, Reference())
        return
    assert told(scene, Reference()).startswith("pass")
    beyond = {"ellipsoid", "spherical_harmonics", "angular_profile"} & set(features(scene))
    if scene.channels == 3 and not beyond:
        assert told(scene, mitsuba).startswith("pass")


SENSORS = (
    Orthographic((0.3, 0.2, 4), (0, 0, 0), (0.1, 1, 0), 3.0, 12, 8),
    ThinLens((0.3, 0.2, 4), (0, 0, 0), (0.1, 1, 0), 50, 12, 8, 0.4, 3.0),
    RadianceMeter((0.3, 0.2, 4), (0, 0, -1)),
)


@pytest.mark.parametrize("sensor", SENSORS, ids=lambda sensor: type(sensor).__name__)
def test_sensors(sensor: Orthographic | ThinLens | RadianceMeter, mitsuba: Witness) -> None:
    grey = Lambertian((0.5, 0.5, 0.5))
    surfaces = (
        Surface("ball", Sphere((0.2, 0.1, 0), 0.7), grey),
        Surface("wall", Quad((-2, -2, -1), (4, 0, 0), (0, 4, 0.5)), grey, two_sided=True),
    )
    scene = Scene(surfaces, sensor, (PointLight((0, 3, 3), (1.0, 1.0, 1.0)),))
    assert told(scene, Reference()).startswith("pass")
    assert told(scene, mitsuba).startswith("pass")


def test_an_irradiance_meter_has_no_ray() -> None:
    scene = Scene(
        (Surface("wall", Quad((-2, -2, -1), (4, 0, 0), (0, 4, 0)), Lambertian((0.5,))),),
        IrradianceMeter((0, 0, 0), (0, 0, -1)),
        (PointLight((0, 3, 3), (1.0,)),),
    )
    with pytest.raises(Unsupported, match="irradiance_meter"):
        ReferenceRenderer("mis").first_hits(scene)


def test_what_is_nowhere_is_told() -> None:
    scene = library.case("furnace-convex").scene.resized(8, 8)
    hits = ReferenceRenderer("mis").first_hits(scene)
    nowhere = hits[4] < 0
    assert nowhere.any()
    assert np.isinf(hits[0, nowhere]).all()
    assert not hits[1:4, nowhere].any()
