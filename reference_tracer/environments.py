"""Environments: radiance from infinitely far, L(d) along d away from the scene, and its importance sampling.

A constant one is sampled uniformly over the sphere of directions. Any other has a table of cells of latitude
and longitude, each with one density p ∝ its mean radiance, uniform by solid angle within:

    p(d) = w / Σ w ΔΩ,   ΔΩ = Δφ (cos θ₀ − cos θ₁)

The weight w of a cell is the mean of its four corners. For the map, whose cells lie between the centres of
pixels, it is zero only where the bilinear radiance is zero all over the cell.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling, spherical_harmonics
from reference_tracer.emitter_sample import EmitterSample
from reference_tracer.propagation import NOWHERE, Points
from scenes import ConstantEnvironment, EnvironmentMap, Scene, SphericalHarmonicsEnvironment

Array = NDArray[np.float64]

ROWS, COLUMNS = 128, 256
"""Cells of the table of a spherical-harmonics environment, and of the grid on which its sign is checked."""

LEAST = 0.05
"""Least weight of such a cell, relative to the mean: radiance may be above zero between zeros at its corners."""

NEGATIVE = 1e-9
"""How far below zero radiance may come by rounding, relative to its maximum."""


class NegativeRadianceError(ValueError):
    """An environment that emits less than nothing somewhere.

    Attributes:
        direction: unit vector, world coordinates.
        radiance: the least channel there.
    """

    def __init__(self, direction: tuple[float, ...], radiance: float) -> None:
        super().__init__(direction, radiance)
        self.direction, self.radiance = direction, radiance

    def __str__(self) -> str:
        where = ", ".join(f"{c:.4g}" for c in self.direction)
        return (
            f"radiance {self.radiance:.4g} from direction ({where}): expected none below 0; "
            "raise the coefficient of l = 0 or shrink the others"
        )


def environment(scene: Scene, radius: float) -> EnvironmentEmitter | None:
    """The environment of a scene; None for black. Its bounding sphere has that radius.

    Raises:
        NegativeRadianceError: a spherical-harmonics environment is negative somewhere.
    """
    light = scene.environment
    if isinstance(light, ConstantEnvironment):
        return Constant(light, radius)
    if isinstance(light, EnvironmentMap):
        return LatitudeLongitudeMap(light, radius)
    return SphericalHarmonics(light, radius) if light is not None else None


class EnvironmentEmitter(ABC):
    """An environment. Densities are per solid angle."""

    def __init__(self, mean: float, radius: float) -> None:
        self.power = 4 * np.pi * mean * np.pi * radius**2

    @abstractmethod
    def radiance(self, d: Array) -> Array:
        """Radiance that comes from unit directions d ``(3, n)``: ``(channels, n)``."""

    @abstractmethod
    def square_to_direction(self, u: Array) -> Array:
        """Directions for u, ``(2, n)``."""

    @abstractmethod
    def square_to_direction_pdf(self, d: Array) -> Array:
        """Density of the above, ``(n,)``."""

    def sample(self, reference: Points, u: Array) -> EmitterSample:
        """A direction for each reference."""
        wi, n = self.square_to_direction(u), len(reference)
        pdf = self.square_to_direction_pdf(wi)
        return EmitterSample(wi, np.full(n, np.inf), self.radiance(wi), pdf, False, np.full(n, NOWHERE))

    def pdf(self, reference: Points, points: Points, wi: Array) -> Array:
        """Density with which ``sample`` chooses wi; the same everywhere."""
        return self.square_to_direction_pdf(wi)


class Constant(EnvironmentEmitter):
    """The same radiance from everywhere."""

    def __init__(self, light: ConstantEnvironment, radius: float) -> None:
        self._radiance = np.array(light.radiance)[:, None]
        super().__init__(float(self._radiance.mean()), radius)

    def radiance(self, d: Array) -> Array:
        """As the base class says."""
        return np.tile(self._radiance, d.shape[1])

    def square_to_direction(self, u: Array) -> Array:
        """Uniform over the sphere."""
        return sampling.square_to_cone(u, 2.0)

    def square_to_direction_pdf(self, d: Array) -> Array:
        """1 / 4π."""
        return np.full(d.shape[1], sampling.square_to_cone_pdf(2.0))


class _Cells:
    """A density over directions that is constant in each cell of latitude and longitude."""

    def __init__(self, corners: Array, theta: Array, shift: float, least: float = 0.0) -> None:
        """Take values ≥ 0 at the corners, ``(rows + 1, columns)``, at polar angles ``(rows + 1,)``.

        The corner of column j has the longitude (j + shift) Δφ. ``least`` is that of a weight, relative to the mean.
        """
        beside = np.roll(corners, -1, axis=1)
        weights = (corners[:-1] + corners[1:] + beside[:-1] + beside[1:]) / 4
        self._columns, self._shift, self._z = corners.shape[1], shift, np.cos(theta)
        solid_angles = -np.diff(self._z)[:, None] * (2 * np.pi / self._columns)
        self.mean = float((weights * solid_angles).sum() / (4 * np.pi))
        weights = np.maximum(weights, least * self.mean)
        flux = (weights * solid_angles).ravel()
        self._density = np.divide(weights, flux.sum(), out=np.zeros_like(weights), where=weights > 0).ravel()
        self._ends = np.cumsum(flux) / (flux.sum() or 1)
        self._shares = flux / (flux.sum() or 1)
        self._last = np.flatnonzero(flux)[-1] if flux.any() else 0

    def sample(self, u: Array) -> Array:
        """Local directions: u[0] chooses a cell, and what remains of it the height within."""
        cell = np.minimum(np.searchsorted(self._ends, u[0], side="right"), self._last)
        rest = np.clip((u[0] - self._ends[cell]) / self._shares[cell] + 1, 0, 1)
        row, column = np.divmod(cell, self._columns)
        z = np.clip(self._z[row] + rest * (self._z[row + 1] - self._z[row]), -1, 1)
        return sampling.from_versine(1 - z, (column + self._shift + u[1]) / self._columns)

    def pdf(self, d: Array) -> Array:
        """Solid angle density, ``(n,)``."""
        rows = len(self._z) - 1
        row = np.clip(np.searchsorted(-self._z, -d[2], side="right") - 1, 0, rows - 1)
        turn = np.arctan2(d[1], d[0]) / (2 * np.pi)
        column = np.floor(turn * self._columns - self._shift).astype(np.intp) % self._columns
        density: Array = self._density[row * self._columns + column]
        return density


class _Tabulated(EnvironmentEmitter):
    """An environment in local axes, with a table of cells."""

    def __init__(self, axes: tuple[tuple[float, ...], ...], cells: _Cells, radius: float) -> None:
        self._axes, self._cells = np.array(axes), cells
        super().__init__(cells.mean, radius)

    def square_to_direction(self, u: Array) -> Array:
        """By the table."""
        return self._axes.T @ self._cells.sample(u)

    def square_to_direction_pdf(self, d: Array) -> Array:
        """By the table."""
        return self._cells.pdf(self._axes @ d)


class LatitudeLongitudeMap(_Tabulated):
    """An image over longitude and latitude, bilinear between the centres of pixels."""

    def __init__(self, light: EnvironmentMap, radius: float) -> None:
        image = light.image.array
        self._rows, self._columns, _ = image.shape
        # one row more at the top and at the bottom: constant beyond the centres of the first and the last
        self._image = np.pad(image, ((1, 1), (0, 0), (0, 0)), mode="edge").transpose(2, 0, 1)
        theta = np.pi * np.clip(np.arange(-0.5, self._rows + 1), 0, self._rows) / self._rows
        super().__init__(light.axes, _Cells(self._image.mean(axis=0), theta, shift=0.5), radius)

    def radiance(self, d: Array) -> Array:
        """As the base class says."""
        x, y, z = self._axes @ d
        theta, phi = np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)
        row, v = _whole_and_part(theta / np.pi * self._rows + 0.5)
        row = np.minimum(row, self._rows)
        left, u = _whole_and_part(phi / (2 * np.pi) * self._columns - 0.5)
        left, right = left % self._columns, (left + 1) % self._columns
        image = self._image
        top = (1 - u) * image[:, row, left] + u * image[:, row, right]
        bottom = (1 - u) * image[:, row + 1, left] + u * image[:, row + 1, right]
        radiance: Array = (1 - v) * top + v * bottom
        return radiance


def _whole_and_part(x: Array) -> tuple[NDArray[np.intp], Array]:
    whole = np.floor(x)
    return whole.astype(np.intp), x - whole


class SphericalHarmonics(_Tabulated):
    """A sum of real spherical harmonics, evaluated as it is; the table serves for sampling alone."""

    def __init__(self, light: SphericalHarmonicsEnvironment, radius: float) -> None:
        self._coefficients, axes = np.array(light.coefficients).T, np.array(light.axes)
        self._order = round(len(light.coefficients) ** 0.5)
        theta = np.linspace(0, np.pi, ROWS + 1)
        turn = np.arange(COLUMNS) / COLUMNS
        grid = sampling.from_versine(np.repeat(2 * np.sin(theta / 2) ** 2, COLUMNS), np.tile(turn, ROWS + 1))
        L = self._sum(grid)
        if (worst := L.min()) < -NEGATIVE * L.max():
            direction = axes.T @ grid[:, L.min(axis=0).argmin()]
            raise NegativeRadianceError(tuple(direction.tolist()), float(worst))
        corners = np.abs(L).mean(axis=0).reshape(ROWS + 1, COLUMNS)
        super().__init__(light.axes, _Cells(corners, theta, shift=0.0, least=LEAST), radius)

    def radiance(self, d: Array) -> Array:
        """As the base class says."""
        return self._sum(self._axes @ d)

    def _sum(self, local: Array) -> Array:
        radiance: Array = self._coefficients @ spherical_harmonics.evaluate(self._order, local)
        return radiance
