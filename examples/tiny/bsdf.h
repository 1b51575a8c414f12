// How surfaces reflect: f, pdf, sample. wi points to the light, wo to the viewer, both away from the surface.
#pragma once

#include "random.h"
#include "vector.h"

/// A direction that a path goes on in.
struct Scattered {
    Vector wi;
    double pdf = 0;  // by solid angle; INFINITE for a single direction, 0 if the path ends
    Colour weight;   // f · cos / pdf
};

class Bsdf {
public:
    virtual ~Bsdf() = default;

    /// f, without the cosine; 0 for what only a single direction contributes to.
    virtual Colour f(Vector n, Vector wi, Vector wo) const = 0;

    /// The density of wi in `sample`, by solid angle.
    virtual double pdf(Vector n, Vector wi, Vector wo) const = 0;

    virtual Scattered sample(Vector n, Vector wo, Random& random) const = 0;
};

/// f = albedo / π on the front (Lambert 1760); sampled by the cosine, so that f · cos / pdf = albedo.
class Lambertian : public Bsdf {
public:
    explicit Lambertian(Colour albedo) : albedo(albedo) {}

    Colour f(Vector n, Vector wi, Vector wo) const override {
        return dot(n, wi) > 0 && dot(n, wo) > 0 ? 1 / PI * albedo : Colour{};
    }

    double pdf(Vector n, Vector wi, Vector wo) const override {
        return dot(n, wo) > 0 ? std::max(dot(n, wi), 0.0) / PI : 0;
    }

    Scattered sample(Vector n, Vector wo, Random& random) const override {
        const double u = random(), phi = 2 * PI * random(), r = std::sqrt(u);
        const Vector wi = around(n, r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - u));
        if (dot(n, wo) <= 0) return {};  // backs are black
        return {wi, pdf(n, wi, wo), albedo};
    }

private:
    Colour albedo;
};

inline Vector mirrored(Vector n, Vector w) { return 2 * dot(n, w) * n - w; }

class Mirror : public Bsdf {
public:
    explicit Mirror(Colour reflectance) : reflectance(reflectance) {}

    Colour f(Vector, Vector, Vector) const override { return {}; }
    double pdf(Vector, Vector, Vector) const override { return 0; }

    Scattered sample(Vector n, Vector wo, Random&) const override {
        if (dot(n, wo) <= 0) return {};
        return {mirrored(n, wo), INFINITE, reflectance};
    }

private:
    Colour reflectance;
};

/// The boundary of two clear media: reflects the share R of Fresnel's equations, refracts the rest.
class Dielectric : public Bsdf {
public:
    /// The indices of refraction behind the surface and in front of it.
    Dielectric(double interior, double exterior) : ratio(interior / exterior) {}

    Colour f(Vector, Vector, Vector) const override { return {}; }
    double pdf(Vector, Vector, Vector) const override { return 0; }

    Scattered sample(Vector n, Vector wo, Random& random) const override {
        const bool outside = dot(n, wo) > 0;
        const double eta = outside ? ratio : 1 / ratio;  // the other medium's index over this one's
        if (!outside) n = -n;
        const double cosine = dot(n, wo);
        const double sine2 = (1 - cosine * cosine) / (eta * eta);  // beyond the boundary, by Snell's law
        const double beyond = std::sqrt(std::max(1 - sine2, 0.0));
        if (random() < reflected(cosine, beyond, eta)) return {mirrored(n, wo), INFINITE, {1, 1, 1}};
        const Vector wi = normalised((cosine / eta - beyond) * n - 1 / eta * wo);
        const double scale = 1 / (eta * eta);  // radiance / index² is what is kept
        return {wi, INFINITE, {scale, scale, scale}};
    }

private:
    /// R of unpolarised light (Born and Wolf 1999, § 1.5.2), from both cosines; 1 if none gets through.
    static double reflected(double cosine, double beyond, double eta) {
        if (beyond == 0) return 1;
        const double s = (cosine - eta * beyond) / (cosine + eta * beyond);
        const double p = (eta * cosine - beyond) / (eta * cosine + beyond);
        return (s * s + p * p) / 2;
    }

    double ratio;
};
