"""Form factors of rectangles: textbook values, and midpoint sums over both of them."""

from __future__ import annotations

import numpy as np
import pytest

from scenes.form_factors import parallel_exchange, perpendicular_exchange, solid_angles

UNIT = np.array([0.0, 1.0])


def test_opposite_faces_of_a_cube() -> None:
    [[factor]] = parallel_exchange(UNIT, UNIT, (0.0, 1.0), (0.0, 1.0), 1.0)
    assert factor == pytest.approx(0.199825, abs=1e-6)  # Howell, C-11


def test_neighbouring_faces_of_a_cube() -> None:
    [[factor]] = perpendicular_exchange(UNIT, UNIT, (0.0, 1.0), (0.0, 1.0))
    [[opposite]] = parallel_exchange(UNIT, UNIT, (0.0, 1.0), (0.0, 1.0), 1.0)
    assert factor == pytest.approx(0.200044, abs=1e-6)  # Howell, C-14
    assert 4 * factor + opposite == pytest.approx(1, abs=1e-14)  # a cube is closed


X, Y = np.array([0.2, 0.9, 1.3]), np.array([-0.4, 0.1, 0.8])
XI, ETA = (0.3, 1.7), (-0.2, 1.5)


def midpoints(low: float, high: float, count: int = 60) -> np.ndarray:
    return low + (high - low) * (np.arange(count) + 0.5) / count


def summed(kernel: str, i: int, j: int, z: float) -> float:
    """By 60⁴ points, in the third direction 60 at a time."""
    x, y = midpoints(X[j], X[j + 1]), midpoints(Y[i], Y[i + 1])
    xi, eta = midpoints(*XI), midpoints(*ETA)
    aside = (y[:, None] - eta).ravel() ** 2
    total = 0.0
    for a in x:
        for b in xi:
            if kernel == "parallel":
                total += (z**2 / (np.pi * ((a - b) ** 2 + z**2 + aside) ** 2)).sum()
            else:
                total += (a * b / (np.pi * (a**2 + b**2 + aside) ** 2)).sum()
    return total * (X[j + 1] - X[j]) * (Y[i + 1] - Y[i]) * (XI[1] - XI[0]) * (ETA[1] - ETA[0]) / 60**4


@pytest.mark.parametrize(("i", "j"), [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_cells_by_sums(i: int, j: int) -> None:
    parallel, perpendicular = parallel_exchange(X, Y, XI, ETA, 0.7), perpendicular_exchange(X, Y, XI, ETA)
    assert parallel.shape == perpendicular.shape == (2, 2)
    assert parallel[i, j] == pytest.approx(summed("parallel", i, j, 0.7), rel=3e-4)
    assert perpendicular[i, j] == pytest.approx(summed("perpendicular", i, j, 0.0), rel=3e-4)


def test_far_away_it_is_the_inverse_square() -> None:
    [[factor]] = parallel_exchange(UNIT, UNIT, (0.0, 1.0), (0.0, 1.0), 300.0)
    assert factor == pytest.approx(1 / (np.pi * 300**2), rel=1e-4)


def test_cells_add_up() -> None:
    x, y = np.linspace(0, 1, 65), np.linspace(0, 1, 33)
    for exchange, more in ((parallel_exchange, (1.0,)), (perpendicular_exchange, ())):
        cells, [[whole]] = exchange(x, y, XI, ETA, *more), exchange(UNIT, UNIT, XI, ETA, *more)
        assert cells.sum() == pytest.approx(whole, rel=1e-12)
        assert (cells > 0).all()


def test_the_faces_of_a_cube_from_its_middle() -> None:
    half = np.array([-1.0, 1.0])
    [[angle]] = solid_angles(half, half, 1.0)
    assert angle == pytest.approx(4 * np.pi / 6, rel=1e-14)


def test_solid_angles_by_quadrature() -> None:
    """∫∫ z / d³ over each cell, which is cos θ / d²."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    found = solid_angles(X - 0.5, Y, 0.6)
    for i, j in np.ndindex(2, 2):
        x = X[j] - 0.5 + (X[j + 1] - X[j]) * (nodes + 1) / 2
        y = Y[i] + (Y[i + 1] - Y[i]) * (nodes + 1) / 2
        kernel = 0.6 / (x**2 + y[:, None] ** 2 + 0.6**2) ** 1.5
        area = (X[j + 1] - X[j]) * (Y[i + 1] - Y[i])
        assert found[i, j] == pytest.approx(weights @ kernel @ weights * area / 4, rel=1e-12)
    assert solid_angles((X - 0.5)[::-1], Y, 0.6).sum() == pytest.approx(-found.sum())
