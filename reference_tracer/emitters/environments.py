"""Environments: radiance from infinitely far, L(d) along d away from the scene, and its importance sampling.

A constant one is sampled uniformly over the sphere of directions. Any other has a table of cells of latitude
and longitude. In each of them the density per solid angle is bilinear in z = cos θ and φ between the values w at
its corners, so that the cell's share of the whole is just

    ¼ (w₀₀ + w₀₁ + w₁₀ + w₁₁) Δz Δφ / Σ

For the map the cells lie between the centres of pixels and w is the mean of the channels: the density is zero
only where the radiance is, and differs from it no more than z from a line in θ.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling, spherical_harmonics
from reference_tracer.emitters.emitter_sample import EmitterSample
from reference_tracer.points import NOWHERE, Points
from scenes import ConstantEnvironment, EnvironmentMap, Scene, SphericalHarmonicsEnvironment

Array = NDArray[np.float64]

ROWS, COLUMNS = 128, 256
"""Cells of the table of a spherical-harmonics environment, and of the grid on which its sign is checked."""

LEAST = 0.05
"""Least value at a corner, relative to the mean: radiance may be above zero between corners where it is zero."""

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
    def square_to_direction(self, u: Array) -> tuple[Array, Array]:
        """Directions for u, ``(2, n)``, and their density, ``(n,)``."""

    @abstractmethod
    def square_to_direction_pdf(self, d: Array) -> Array:
        """Density of the above, ``(n,)``."""

    def sample(self, reference: Points, u: Array) -> EmitterSample:
        """A direction for each reference."""
        (wi, pdf), n = self.square_to_direction(u), len(reference)
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

    def square_to_direction(self, u: Array) -> tuple[Array, Array]:
        """Uniform over the sphere."""
        d = sampling.square_to_cone(u, 2.0)
        return d, self.square_to_direction_pdf(d)

    def square_to_direction_pdf(self, d: Array) -> Array:
        """1 / 4π."""
        return np.full(d.shape[1], sampling.square_to_cone_pdf(2.0))


class _Cells:
    """A density over directions that is bilinear in z and φ in each cell of latitude and longitude."""

    def __init__(self, corners: Array, theta: Array, shift: float, least: float = 0.0) -> None:
        """Take values ≥ 0 at the corners, ``(rows + 1, columns)``, at polar angles ``(rows + 1,)``.

        The corner of column j has the longitude (j + shift) Δφ. Values below ``least`` times the mean are raised.
        """
        self._columns, self._shift, self._z = corners.shape[1], shift, np.cos(theta)
        self.mean = float(self._flux(corners).sum()) / (4 * np.pi)
        flux = self._flux(np.maximum(corners, least * self.mean)).ravel()
        self._values = np.maximum(corners, least * self.mean) / (flux.sum() or 1)
        self._shares = flux / (flux.sum() or 1)
        self._ends = np.cumsum(self._shares)
        self._last = np.flatnonzero(flux)[-1] if flux.any() else 0

    def _flux(self, corners: Array) -> Array:
        """The integral over each cell, ``(rows, columns)``."""
        heights, beside = -np.diff(self._z)[:, None], np.roll(corners, -1, axis=1)
        mean = (corners[:-1] + corners[1:] + beside[:-1] + beside[1:]) / 4
        flux: Array = mean * heights * (2 * np.pi / self._columns)
        return flux

    def sample(self, u: Array) -> tuple[Array, Array]:
        """Local directions and their density: u[0] chooses a cell, and what remains of it the height within."""
        cell = np.minimum(np.searchsorted(self._ends, u[0], side="right"), self._last)
        rest = np.clip((u[0] - self._ends[cell]) / self._shares[cell] + 1, 0, 1)
        row, column = np.divmod(cell, self._columns)
        (a, b), (c, d) = self._corners(row, column)
        t = sampling.unit_to_linear(rest, a + b, c + d)
        s = sampling.unit_to_linear(u[1], _mix(t, a, c), _mix(t, b, d))
        density = _mix(t, _mix(s, a, b), _mix(s, c, d))
        z = np.clip(_mix(t, self._z[row], self._z[row + 1]), -1, 1)
        direction = sampling.from_versine(1 - z, (column + self._shift + s) / self._columns)
        return direction, np.where(density > 0, density, 1)  # at a dark corner itself: no light, no NaN

    def pdf(self, d: Array) -> Array:
        """Solid angle density, ``(n,)``."""
        row = np.clip(np.searchsorted(-self._z, -d[2], side="right") - 1, 0, len(self._z) - 2)
        t = np.clip((d[2] - self._z[row]) / (self._z[row + 1] - self._z[row]), 0, 1)
        column, s = _whole_and_part(np.arctan2(d[1], d[0]) / (2 * np.pi) * self._columns - self._shift)
        (a, b), (c, e) = self._corners(row, column % self._columns)
        return _mix(t, _mix(s, a, b), _mix(s, c, e))

    def _corners(
        self, row: NDArray[np.intp], column: NDArray[np.intp]
    ) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """The values above, left and right, and below."""
        right, values = (column + 1) % self._columns, self._values
        return (values[row, column], values[row, right]), (values[row + 1, column], values[row + 1, right])


def _mix(t: Array, a: Array, b: Array) -> Array:
    return (1 - t) * a + t * b


class _Tabulated(EnvironmentEmitter):
    """An environment in local axes, with a table of cells."""

    def __init__(self, axes: tuple[tuple[float, ...], ...], cells: _Cells, radius: float) -> None:
        self._axes, self._cells = np.array(axes), cells
        super().__init__(cells.mean, radius)

    def square_to_direction(self, u: Array) -> tuple[Array, Array]:
        """By the table."""
        local, density = self._cells.sample(u)
        return self._axes.T @ local, density

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
        left, u = _whole_and_part(phi / (2 * np.pi) * self._columns - 0.5)
        left, right = left % self._columns, (left + 1) % self._columns
        image = self._image
        top = _mix(u, image[:, row, left], image[:, row, right])
        return _mix(v, top, _mix(u, image[:, row + 1, left], image[:, row + 1, right]))


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
