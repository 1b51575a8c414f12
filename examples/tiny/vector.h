// Three numbers: a point, a direction, or radiance in three channels.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

constexpr double PI = std::numbers::pi;
constexpr double INFINITE = std::numeric_limits<double>::infinity();

struct Vector {
    double x = 0, y = 0, z = 0;
};

using Colour = Vector;  // red, green, blue: scene-linear radiance, or a factor on it

inline Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector operator-(Vector a) { return {-a.x, -a.y, -a.z}; }
inline Vector operator*(double s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
inline Colour operator*(Colour a, Colour b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vector& operator+=(Vector& a, Vector b) { return a = a + b; }

inline double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector cross(Vector a, Vector b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(Vector a) { return std::sqrt(dot(a, a)); }
inline Vector normalised(Vector a) { return 1 / length(a) * a; }
inline double largest(Colour a) { return std::max({a.x, a.y, a.z}); }

/// The direction whose coordinates are (x, y, z) in an orthonormal frame with `n` as its third axis.
inline Vector around(Vector n, double x, double y, double z) {
    const Vector aside = std::abs(n.x) > 0.7 ? Vector{0, 1, 0} : Vector{1, 0, 0};
    const Vector s = normalised(cross(aside, n));
    return x * s + y * cross(n, s) + z * n;
}
