"""Warps from the unit square to directions, each with its density right below, and random streams.

Arrays lie by component: a block of n vectors is ``(3, n)``, a block of n points of the unit square ``(2, n)``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference_tracer.vectors import dot, norm

Array = NDArray[np.float64]


def stream(seed: int, *place: int) -> np.random.Generator:
    """A random stream that depends on the seed and on its place (block, replicate …) and on nothing else."""
    # SFC64 is the fastest of NumPy's bit generators; SeedSequence makes streams of nearby seeds independent
    return np.random.Generator(np.random.SFC64(np.random.SeedSequence(seed, spawn_key=place)))


def circle(turn: Array) -> Array:
    """cos 2πu and sin 2πu, ``(2, n)``, from the tangent of the half angle.

    NumPy vectorises tan in float64, but not cos and sin: this takes a quarter of their time.
    """
    tangent = np.tan(np.pi * turn)
    cosine_and_one = 2 / (1 + tangent * tangent)
    return np.stack([cosine_and_one - 1, tangent * cosine_and_one])


def square_to_cosine_hemisphere(u: Array) -> Array:
    """Directions about +z with density cos θ / π: a disk, lifted (Malley)."""
    return np.stack([*np.sqrt(u[0]) * circle(u[1]), np.sqrt(1 - u[0])])


def square_to_cosine_hemisphere_pdf(cos_theta: Array) -> Array:
    """Solid angle density cos θ / π of the above."""
    return np.maximum(cos_theta, 0) / np.pi


def unit_to_linear(u: Array, a: Array, b: Array) -> Array:
    """Numbers t in [0, 1] with a density that goes linearly from a to b, up to its norm; a, b ≥ 0.

    The solution of ∫₀ᵗ = u ∫₀¹, (b − a) t²/2 + a t = u (a + b)/2, in the form in which nothing cancels.
    """
    root = np.sqrt((1 - u) * a**2 + u * b**2)
    below = a + root
    t: Array = np.divide(u * (a + b), below, out=np.zeros_like(root), where=below > 0)
    return np.minimum(t, 1)


def unit_to_linear_pdf(t: Array, a: Array, b: Array) -> Array:
    """Density 2 (a + (b − a) t) / (a + b) of the above."""
    return 2 * ((1 - t) * a + t * b) / (a + b)


def square_to_zone(u: Array, cos_low: Array | float, cos_high: Array | float) -> Array:
    """Points of the unit sphere, uniform on the zone cos_low ≤ z ≤ cos_high (Archimedes: uniform in z)."""
    z = cos_low + (cos_high - cos_low) * u[0]
    return np.stack([*np.sqrt(np.maximum(1 - z**2, 0)) * circle(u[1]), z])


def square_to_zone_pdf(cos_low: Array | float, cos_high: Array | float) -> Array | float:
    """Density per area of the unit sphere, 1 / 2π(cos_high − cos_low), of the above."""
    return 1 / (2 * np.pi * (cos_high - cos_low))


def square_to_cone(u: Array, versine: Array | float) -> Array:
    """Directions about +z, uniform by solid angle in the cone 1 − cos θ ≤ ``versine``.

    The versine and not the cosine: a narrow cone would lose its digits in 1 − cos θ. All of them stay in
    sin² θ = w (2 − w), w = 1 − cos θ. A versine of 2 is the whole sphere.
    """
    return from_versine(versine * u[0], u[1])


def square_to_cone_pdf(versine: Array | float) -> Array | float:
    """Solid angle density 1 / 2π(1 − cos θ) of the above."""
    return 1 / (2 * np.pi * versine)


def from_versine(versine: Array, turn: Array) -> Array:
    """The directions with that 1 − cos θ, and the azimuth as a share of a full turn."""
    radius: Array = np.sqrt(versine * (2 - versine))
    return np.stack([*radius * circle(turn), 1 - versine])


def square_to_disk(u: Array) -> Array:
    """Points of the unit disk, uniform by area, ``(2, n)``."""
    points: Array = np.sqrt(u[0]) * circle(u[1])
    return points


def square_to_disk_pdf() -> float:
    """Density per area, 1 / π, of the above."""
    return 1 / np.pi


def square_to_triangle(u: Array) -> Array:
    """Points of the triangle s, t ≥ 0, s + t ≤ 1, uniform by area, ``(2, n)``."""
    root = np.sqrt(u[0])
    return np.stack([1 - root, root * u[1]])


def square_to_triangle_pdf() -> float:
    """Density per area, 2, of the above."""
    return 2.0


def square_to_spherical_rectangle(u: Array, low: Array, high: Array, height: Array) -> Array:
    """Points of rectangles, uniform by the solid angle under which the origin sees them.

    Ureña, Fajardo and King 2013, An area-preserving parametrization for spherical rectangles, EGSR 32(4),
    section 3, with the angles at the corners written by arctangents instead of arccosines, which keep their
    digits for flat angles too. The part left of x has the solid angle F(x) − F(x₀),

        F(x) = asin(c s₁) − asin(c s₀),   c = x / √(x² + h²),   sᵢ = yᵢ / √(yᵢ² + h²),

    which is solved for c. Within one x, the sine of the elevation towards y is uniform.

    Args:
        u: ``(2, n)``.
        low, high: opposite corners (x₀, y₀) and (x₁, y₁) as seen from the origin, ``(2, n)``.
        height: h > 0, distance from the origin to the plane, ``(n,)``.

    Returns:
        (x, y), ``(2, n)``.
    """
    start = _left_of(low[0], low, high, height)
    a = start + u[0] * (_left_of(high[0], low, high, height) - start)
    s0, s1 = (y / np.hypot(y, height) for y in (low[1], high[1]))
    adjacent, opposite = s1 * np.cos(a) - s0, np.sin(a)
    # c = opposite / hypot(adjacent, s1 · opposite), and x = h c / √(1 − c²)
    rest = height / np.hypot(high[1], height) * opposite
    cosine = np.sqrt(np.maximum((adjacent - rest) * (adjacent + rest), 0))
    with np.errstate(divide="ignore", invalid="ignore"):  # rounding at the far end of the plane: the edge
        x = np.clip(np.nan_to_num(height * opposite / cosine), low[0], high[0])
    across = np.hypot(x, height)
    h0, h1 = (y / np.hypot(y, across) for y in (low[1], high[1]))
    elevation = h0 + u[1] * (h1 - h0)
    with np.errstate(divide="ignore"):
        y = across * elevation / np.sqrt(1 - elevation**2)
    return np.stack([x, np.clip(y, low[1], high[1])])


def square_to_spherical_rectangle_pdf(low: Array, high: Array, height: Array) -> Array:
    """Solid angle density of the above: one over the solid angle, inf where rounding leaves none."""
    angle = spherical_rectangle_angle(low, high, height)
    return np.divide(1, angle, out=np.full_like(angle, np.inf), where=angle > 0)


def spherical_rectangle_angle(low: Array, high: Array, height: Array) -> Array:
    """Solid angle, sr, under which the origin sees the rectangles, ``(n,)``: F(x₁) − F(x₀)."""
    return _left_of(high[0], low, high, height) - _left_of(low[0], low, high, height)


def _left_of(x: Array, low: Array, high: Array, height: Array) -> Array:
    """F(x): tan asin(c s) = x y / (h √(x² + y² + h²))."""
    corners = (np.arctan2(x * y, height * np.sqrt(x**2 + y**2 + height**2)) for y in (high[1], low[1]))
    top, bottom = corners
    angle: Array = top - bottom
    return angle


def square_to_spherical_triangle(u: Array, a: Array, b: Array, c: Array) -> Array:
    """Directions in spherical triangles with the corners a, b, c, uniform by solid angle, ``(3, n)``.

    Arvo 1995, Stratified sampling of spherical triangles, SIGGRAPH, section 2: a triangle a, b, c′ of the wanted
    share, c′ on the arc from a to c, then a point of the arc from b to c′. Sine and cosine of the angle α at a
    come from products of the corners: a × b and a × c are at that angle, and (a × b) × (a × c) = a (a · b × c).
    """
    part = u[0] * spherical_triangle_angle(a, b, c)
    ab, ac = np.cross(a, b, axis=0), np.cross(a, c, axis=0)
    cos_alpha, sin_alpha = dot(ab, ac), np.abs(dot(ab, c))
    scale = np.hypot(cos_alpha, sin_alpha)
    cos_alpha, sin_alpha = cos_alpha / scale, sin_alpha / scale
    cos_c = dot(a, b)
    # eq. 1: q = cos b′, with s = sin(part − α) and t = cos(part − α)
    s = np.sin(part) * cos_alpha - np.cos(part) * sin_alpha
    t = np.cos(part) * cos_alpha + np.sin(part) * sin_alpha
    p, r = t - cos_alpha, s + sin_alpha * cos_c
    above, below = (r * t - p * s) * cos_alpha - r, (r * s + p * t) * sin_alpha
    q = np.clip(np.divide(above, below, out=np.ones_like(below), where=below != 0), -1, 1)
    corner = _along_arc(a, c, q)
    return _along_arc(b, corner, 1 - u[1] * (1 - dot(corner, b)))


def square_to_spherical_triangle_pdf(a: Array, b: Array, c: Array) -> Array:
    """Solid angle density of the above: one over the solid angle."""
    density: Array = 1 / spherical_triangle_angle(a, b, c)
    return density


def spherical_triangle_angle(a: Array, b: Array, c: Array) -> Array:
    """Solid angle, sr, of spherical triangles; tan Ω/2 (van Oosterom and Strackee 1983, eq. 8), ``(n,)``."""
    ab, bc, ca = (dot(p, q) for p, q in ((a, b), (b, c), (c, a)))
    volume = np.abs(dot(np.cross(a, b, axis=0), c))
    angle: Array = 2 * np.arctan2(volume, 1 + ab + bc + ca)
    return angle


def _along_arc(start: Array, towards: Array, cosine: Array) -> Array:
    """The point of an arc at an angle from its start."""
    across = towards - dot(start, towards) * start
    length = norm(across)
    across /= np.where(length > 0, length, 1)
    point: Array = cosine * start + np.sqrt(np.maximum(1 - cosine**2, 0)) * across
    return point


def frame(n: Array) -> tuple[Array, Array]:
    """Two unit vectors that form a right-handed frame (s, t, n) with each normal, ``(3, n)`` each.

    Duff et al. 2017, Building an orthonormal basis, revisited, JCGT 6(1), listing 3.
    """
    sign = np.copysign(1.0, n[2])
    a = -1 / (sign + n[2])
    b = n[0] * n[1] * a
    s = np.stack([1 + sign * n[0] ** 2 * a, sign * b, -sign * n[0]])
    t = np.stack([b, sign + n[1] ** 2 * a, -n[1]])
    return s, t


def to_world(local: Array, n: Array) -> Array:
    """Directions given in the frame about n, in world coordinates, ``(3, n)``."""
    s, t = frame(n)
    world: Array = local[0] * s + local[1] * t + local[2] * n
    return world
