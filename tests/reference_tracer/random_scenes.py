"""Random scenes of moderate size, with every shape, material, light and sensor, the camera among them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from scenes import (
    AreaLight,
    Blend,
    Checkerboard,
    Conductor,
    ConstantEnvironment,
    Dielectric,
    DirectionalLight,
    Disk,
    Ellipsoid,
    EnvironmentMap,
    Image,
    ImageTexture,
    IrradianceMeter,
    Lambertian,
    Light,
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
    Sensor,
    Shape,
    Sphere,
    SphericalHarmonicsEnvironment,
    SpotLight,
    Surface,
    ThinLens,
)
from scenes.materials import has_dielectric


class Draw:
    """Draws parts of scenes."""

    def __init__(self, *seed: int) -> None:
        self.rng, self.more = np.random.default_rng(seed), np.random.default_rng((*seed, 1))
        self.channels = int(self.rng.integers(1, 4))

    def number(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def values(self, low: float, high: float) -> tuple[float, ...]:
        return tuple(self.rng.uniform(low, high, self.channels).tolist())

    def happens(self, chance: float) -> bool:
        return bool(self.rng.random() < chance)

    def point(self, reach: float = 2.0) -> Any:
        return tuple(self.rng.uniform(-reach, reach, 3).tolist())

    def one_of(self, *makers: Callable[[], Any]) -> Any:
        return makers[self.rng.integers(len(makers))]()

    def shape(self) -> Shape:
        turn, c, scale = np.linalg.qr(self.rng.normal(size=(3, 3)))[0], self.point(), self.number(0.5, 2.0)
        u, v, w = (scale * turn.T * self.rng.uniform(0.4, 1.0, (3, 1))).tolist()
        v = (np.array(v) + self.number(-0.7, 0.7) * np.array(u)).tolist()
        inward = self.happens(0.2)
        return self.one_of(
            lambda: Quad(c, u, v),
            lambda: Disk(c, u, v),
            lambda: Sphere(c, 0.7 * scale, inward),
            lambda: Ellipsoid(c, u, v, w, inward),
            lambda: self.mesh(np.array([u, v, w]), np.array(c)),
        )

    def mesh(self, axes: np.ndarray, center: np.ndarray) -> Mesh:
        """An octahedron, with the normals of a sphere or without."""
        corners = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
        faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
        order = [0, 1, 2] if np.linalg.det(axes) > 0 else [0, 2, 1]
        normals = corners @ axes if self.happens(0.5) else None  # on the front, since it is convex
        uv = self.rng.uniform(0, 2, (6, 2))
        return Mesh(corners @ axes + center, np.array(faces)[:, order], normals, uv)

    def material(self, nested: int = 0) -> Material:
        metal, alpha = (self.values(0.2, 2), self.values(1, 4)), self.number(0.25, 1)
        inside, outside = self.rng.permutation([1.0, self.number(1.2, 1.8)]).tolist()
        shadowing: Any = "separable" if self.happens(0.3) else "correlated"
        pixels = self.rng.random((*self.rng.integers(1, 4, 2), self.channels)).tolist()
        makers: list[Callable[[], Material]] = [
            lambda: Lambertian(self.values(0.1, 1)),
            lambda: Lambertian(Checkerboard(self.values(0, 1), self.values(0, 1), 3, 2)),
            lambda: Lambertian(ImageTexture(Image(pixels), "nearest" if self.happens(0.5) else "bilinear")),
            lambda: Mirror(self.values(0.3, 1)),
            lambda: Dielectric(inside, outside),
            lambda: Conductor(*metal),
            lambda: RoughConductor(*metal, alpha, shadowing),
            lambda: RoughDielectric(alpha, inside, outside, shadowing),
        ]
        if nested < 2:
            makers += 2 * [
                lambda: Blend(self.material(nested + 1), self.material(nested + 1), self.number(0, 1))
            ]
        return self.one_of(*makers)

    def surface(self, name: str, emits: bool) -> Surface:
        material, shape, emission = self.material(), self.shape(), None
        if emits:
            zoned = isinstance(shape, Sphere) and self.happens(0.5)
            zone = PolarRange(self.number(0, 70), self.number(100, 180), self.point()) if zoned else None
            emission = AreaLight(self.values(0.5, 3), zone, self.profile())
        return Surface(name, shape, material, emission, self.happens(0.4) and not has_dielectric(material))

    def profile(self) -> Any:
        """Nothing, or factors at two to five cosines."""
        rows = self.more.uniform(0.3, 2, (self.more.integers(2, 6), self.channels))
        return rows.tolist() if self.more.random() < 0.4 else None

    def lights(self) -> list[Light]:
        axes = np.linalg.qr(self.rng.normal(size=(3, 3)))[0].tolist()
        pixels = (2 * self.rng.random((*self.rng.integers(1, 6, 2), self.channels)) ** 3).tolist()
        waves = 0.05 * self.rng.normal(size=(9, self.channels))
        waves[0] = 1
        found = [
            self.one_of(
                lambda: PointLight(self.point(), self.values(0.5, 3)),
                lambda: SpotLight(self.point(), self.point(), self.values(0.5, 3), 60.0, 20.0),
                lambda: DirectionalLight(self.point(), self.values(0.5, 3)),
            )
            for _ in range(self.rng.integers(3))
        ]
        if self.happens(0.5):
            environment = self.one_of(
                lambda: ConstantEnvironment(self.values(0.1, 1)),
                lambda: EnvironmentMap(Image(pixels), axes),
                lambda: SphericalHarmonicsEnvironment(waves.tolist(), axes),
            )
            found.append(environment)
        return found

    def sensor(self) -> Sensor:
        place = self.point(3.0), self.point(0.5), self.point()
        return self.one_of(
            lambda: Pinhole(*place, self.number(30, 90), 4, 3),
            lambda: ThinLens(*place, self.number(30, 90), 4, 3, 0.2, self.number(1, 4)),
            lambda: Orthographic(*place, self.number(1, 4), 4, 3),
            lambda: IrradianceMeter(*place[:2]),
        )

    def scene(self) -> Scene:
        surfaces = [self.surface(f"{i}", i == 0 or self.happens(0.3)) for i in range(self.rng.integers(1, 6))]
        if self.happens(0.4):
            surfaces.append(Surface("room", Sphere((0, 0, 0), 6.0, True), Lambertian(self.values(0.2, 0.8))))
        return Scene(surfaces, self.sensor(), self.lights())


def random_scene(seed: int) -> Scene:
    return Draw(seed).scene()
