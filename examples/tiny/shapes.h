// Shapes: where a ray meets them, which way they face, and points on them, uniform by area.
#pragma once

#include "vector.h"

class Shape;

/// A half line. There is no offset to keep it off the surface that it leaves: that surface is known.
struct Ray {
    Vector origin, direction;      // a unit vector
    const Shape* leaves = nullptr;  // the shape that the origin lies on
};

class Shape {
public:
    virtual ~Shape() = default;

    /// Distance to the first point of the shape, INFINITE if there is none.
    virtual double meet(const Ray& ray) const = 0;

    /// Unit normal of the front, at a point of the shape.
    virtual Vector normal(Vector x) const = 0;

    /// A point with density 1 / area, from two numbers in (0, 1).
    virtual Vector sample(double u, double v) const = 0;
    virtual double area() const = 0;
};

/// Part of a plane, the points origin + s·a + t·b; its front is where a × b points to.
class Flat : public Shape {
public:
    enum Outline { parallelogram, triangle, ellipse };

    Flat(Outline outline, Vector origin, Vector a, Vector b) : outline(outline), origin(origin), a(a), b(b) {
        const Vector product = cross(a, b);
        n = normalised(product);
        along_a = 1 / dot(product, product) * cross(b, product);  // dot(along_a, s·a + t·b) = s
        along_b = 1 / dot(product, product) * cross(product, a);
    }

    double meet(const Ray& ray) const override {
        if (ray.leaves == this) return INFINITE;
        const Vector to_origin = origin - ray.origin;
        const double distance = dot(to_origin, n) / dot(ray.direction, n);
        if (!(distance > 0 && distance < INFINITE)) return INFINITE;
        const Vector x = distance * ray.direction - to_origin;
        return holds(dot(along_a, x), dot(along_b, x)) ? distance : INFINITE;
    }

    Vector normal(Vector) const override { return n; }

    Vector sample(double u, double v) const override {
        if (outline == ellipse) {
            const double r = std::sqrt(u), phi = 2 * PI * v;
            return origin + r * std::cos(phi) * a + r * std::sin(phi) * b;
        }
        if (outline == triangle && u + v > 1) u = 1 - u, v = 1 - v;  // the other half of the parallelogram
        return origin + u * a + v * b;
    }

    double area() const override {
        const double share = outline == parallelogram ? 1 : outline == triangle ? 0.5 : PI;
        return share * length(cross(a, b));
    }

private:
    bool holds(double s, double t) const {
        if (outline == ellipse) return s * s + t * t <= 1;
        if (outline == triangle) return s >= 0 && t >= 0 && s + t <= 1;
        return s >= 0 && s <= 1 && t >= 0 && t <= 1;
    }

    Outline outline;
    Vector origin, a, b, n, along_a, along_b;
};

/// A sphere; its front is the outside, or the inside where it is a cavity.
class Sphere : public Shape {
public:
    Sphere(Vector center, double radius, bool inward) : center(center), radius(radius), inward(inward) {}

    double meet(const Ray& ray) const override {
        const Vector to_center = center - ray.origin;
        const double middle = dot(to_center, ray.direction);
        if (ray.leaves == this) return middle > 0 ? 2 * middle : INFINITE;  // one root is 0, this is the other
        // the discriminant from the distance of the centre to the ray, which does not cancel far away
        const Vector aside = to_center - middle * ray.direction;
        const double square = radius * radius - dot(aside, aside);
        if (square <= 0) return INFINITE;
        const double half = std::sqrt(square);
        return middle - half > 0 ? middle - half : middle + half > 0 ? middle + half : INFINITE;
    }

    Vector normal(Vector x) const override { return (inward ? -1 : 1) * normalised(x - center); }

    Vector sample(double u, double v) const override { return zone({0, 0, 1}, -1, 1, u, v); }
    double area() const override { return 4 * PI * radius * radius; }

    /// A point, uniform in the zone in which cos θ lies in [low, high], θ the angle to an axis.
    ///
    /// Its area is that of the cylinder around it (Archimedes), so that the cosine is uniform.
    Vector zone(Vector axis, double low, double high, double u, double v) const {
        const double cosine = low + u * (high - low), sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
        const double phi = 2 * PI * v;
        return center + radius * around(axis, sine * std::cos(phi), sine * std::sin(phi), cosine);
    }

    /// cos θ of a point.
    double cosine(Vector axis, Vector x) const { return dot(x - center, axis) / radius; }

private:
    Vector center;
    double radius;
    bool inward;
};
