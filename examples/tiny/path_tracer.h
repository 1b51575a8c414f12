// The path tracer: one walk estimates every term of L = E + TE + T²E + …
#pragma once

#include <optional>

#include "scene.h"

class PathTracer {
public:
    /// `bounces` is the last one; without it a path goes on until Russian roulette ends it.
    PathTracer(const Scene& scene, std::optional<int> bounces) : scene(scene), bounces(bounces) {}

    /// Walk along the ray; add what is found to `terms`, which has a place per bounce and grows as needed.
    void walk(Ray ray, Random& random, std::vector<Colour>& terms) const;

private:
    /// Direct light at a vertex: f · cos · Li / pdf of one point of one light, by the balance heuristic.
    Colour next_event(const Hit& vertex, Vector wo, Random& random) const;

    /// Whether a light is met, and nothing before it.
    bool sees(const Ray& ray, const Incident& light) const;

    const Scene& scene;
    std::optional<int> bounces;
};
