// Lights that a path looks for by itself, at every vertex: next event. An environment is left to chance.
#pragma once

#include "shapes.h"

/// What a point may receive from a light.
struct Incident {
    Vector wi;             // towards the light
    double distance = 0;   // of a light without extent; INFINITE for the sun
    Colour Li;             // radiance; of a light without extent: irradiance across wi
    double pdf = 1;        // of wi, by solid angle
    const Shape* on = nullptr;  // the shape that shines; none for a light without extent
};

class Light {
public:
    virtual ~Light() = default;

    /// What x receives, if nothing is in the way; two numbers in (0, 1) choose from where.
    virtual Incident sample(Vector x, double u, double v) const = 0;
};

/// A shape whose front emits, everywhere or, if it is a sphere, in a zone.
class AreaLight : public Light {
public:
    AreaLight(const Shape& shape, Colour radiance) : shape(shape), radiance(radiance), area(shape.area()) {}

    /// Only where the cosine of the polar angle to the axis lies in [low, high].
    AreaLight(const Sphere& sphere, Colour radiance, Vector axis, double low, double high)
        : shape(sphere), sphere(&sphere), radiance(radiance), axis(axis), low(low), high(high),
          area(sphere.area() * (high - low) / 2) {}

    Colour Le(Vector x, Vector wo) const {
        const bool dark = dot(shape.normal(x), wo) <= 0 || !holds(x);
        return dark ? Colour{} : radiance;
    }

    Incident sample(Vector x, double u, double v) const override {
        const Vector y = sphere ? sphere->zone(axis, low, high, u, v) : shape.sample(u, v);
        const Vector wi = normalised(y - x);
        return {wi, 0, Le(y, -wi), pdf(x, y), &shape};
    }

    /// The density, by solid angle seen from x, of choosing the point y of the light: r² / (area · cos).
    double pdf(Vector x, Vector y) const {
        const Vector d = y - x;
        const double r2 = dot(d, d), cosine = -dot(shape.normal(y), d) / std::sqrt(r2);
        return holds(y) && cosine > 0 ? r2 / (area * cosine) : 0;
    }

private:
    bool holds(Vector x) const {
        if (!sphere) return true;
        const double cosine = sphere->cosine(axis, x);
        return low <= cosine && cosine <= high;
    }

    const Shape& shape;
    const Sphere* sphere = nullptr;  // only if it is a zone that emits
    Colour radiance;
    Vector axis;
    double low = -1, high = 1, area;
};

/// A point with the full intensity up to the angle `beam` from its axis, none from `cutoff` on, linear between.
class SpotLight : public Light {
public:
    SpotLight(Vector position, Colour intensity, Vector axis = {0, 0, 1}, double beam = PI, double cutoff = PI)
        : position(position), intensity(intensity), axis(axis), beam(beam), cutoff(cutoff) {}

    Incident sample(Vector x, double, double) const override {
        const Vector d = position - x;
        const double r = length(d);
        return {1 / r * d, r, share(-1 / r * d) / (r * r) * intensity};
    }

private:
    double share(Vector w) const {
        const double angle = std::acos(std::clamp(dot(axis, w), -1.0, 1.0));
        return angle <= beam ? 1 : angle >= cutoff ? 0 : (cutoff - angle) / (cutoff - beam);
    }

    Vector position;
    Colour intensity;
    Vector axis;
    double beam, cutoff;  // radians
};

/// Parallel light.
class DirectionalLight : public Light {
public:
    DirectionalLight(Vector direction, Colour irradiance) : wi(-direction), irradiance(irradiance) {}

    Incident sample(Vector, double, double) const override { return {wi, INFINITE, irradiance}; }

private:
    Vector wi;
    Colour irradiance;
};
