#include "path_tracer.h"

namespace {
constexpr std::size_t FIRST_ROULETTE = 3;  // bounces before a path may be ended by chance
constexpr double LONGEST = 0.95;           // the chance to go on is never higher: closed white rooms end, too
}  // namespace

void PathTracer::walk(Ray ray, Random& random, std::vector<Colour>& terms) const {
    Colour throughput{1, 1, 1};
    double pdf = INFINITE;  // of the ray's direction; no other strategy finds what the camera sees

    for (std::size_t k = 0;; ++k) {
        if (terms.size() <= k) terms.resize(k + 1);
        const Hit hit = scene.meet(ray);
        if (!hit.surface) {
            terms[k] += throughput * scene.environment;
            return;
        }
        const Vector wo = -ray.direction;

        // ---- emission that was met by chance: TᵏE
        if (const AreaLight* light = hit.surface->light) {
            const double chosen = light->pdf(ray.origin, hit.x) / static_cast<double>(scene.lights.size());
            const double weight = 1 / (1 + chosen / pdf);  // the balance heuristic, pdf / (pdf + chosen)
            terms[k] += weight * throughput * light->Le(hit.x, wo);
        }
        if (bounces && k == static_cast<std::size_t>(*bounces)) return;

        // ---- next event: one part of Tᵏ⁺¹E
        if (terms.size() <= k + 1) terms.resize(k + 2);
        terms[k + 1] += throughput * next_event(hit, wo, random);

        // ---- reflection
        const Scattered next = hit.surface->bsdf->sample(hit.n, wo, random);
        throughput = throughput * next.weight;
        if (largest(throughput) == 0) return;  // as behind surfaces, whose backs are black
        pdf = next.pdf;
        ray = {hit.x, next.wi, hit.surface->shape.get()};

        // ---- Russian roulette, unless a depth was asked for
        if (!bounces && k + 1 >= FIRST_ROULETTE) {
            const double goes_on = std::min(largest(throughput), LONGEST);
            if (random() >= goes_on) return;
            throughput = 1 / goes_on * throughput;
        }
    }
}

Colour PathTracer::next_event(const Hit& vertex, Vector wo, Random& random) const {
    if (scene.lights.empty()) return {};
    const auto count = static_cast<double>(scene.lights.size());
    const auto choice = static_cast<std::size_t>(random() * count);
    const double u = random(), v = random();
    const Incident light = scene.lights[choice]->sample(vertex.x, u, v);

    const Bsdf& bsdf = *vertex.surface->bsdf;
    const Colour f = bsdf.f(vertex.n, light.wi, wo);
    if (largest(f * light.Li) == 0) return {};  // not worth a shadow ray
    if (!sees({vertex.x, light.wi, vertex.surface->shape.get()}, light)) return {};

    double pdf = light.pdf / count;
    if (light.on) pdf += bsdf.pdf(vertex.n, light.wi, wo);  // balance: w / p = 1 / (p + p_bsdf)
    return dot(vertex.n, light.wi) / pdf * f * light.Li;
}

bool PathTracer::sees(const Ray& ray, const Incident& light) const {
    const Hit hit = scene.meet(ray);
    if (!light.on) return hit.distance >= light.distance;
    // a ray meets the front of a shape only once, so no distance has to be compared
    return hit.surface && hit.surface->shape.get() == light.on && dot(hit.n, ray.direction) < 0;
}
