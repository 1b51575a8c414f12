#include "scene.h"

#include <fstream>
#include <initializer_list>
#include <nlohmann/json.hpp>

using nlohmann::json;

namespace {

/// Refuse what has another field than these: a feature that was left out would make a wrong image.
void expect_fields(const json& part, std::initializer_list<std::string> names) {
    for (const auto& [name, value] : part.items())
        if (std::ranges::find(names, name) == names.end()) throw Unsupported(name);
}

Vector vector(const json& list) { return {list.at(0), list.at(1), list.at(2)}; }
Vector direction(const json& list) { return normalised(vector(list)); }
double radians(double degrees) { return degrees / 180 * PI; }

class Reader {
public:
    Scene read(const json& document) {
        expect_fields(document, {"$schema", "surfaces", "sensor", "lights"});
        camera(document.at("sensor"));
        for (const json& part : document.at("surfaces")) surface(part);
        for (const json& part : document.value("lights", json::array())) light(part);
        return std::move(scene);
    }

private:
    /// A number per channel.
    Colour colour(const json& list) {
        scene.channels = static_cast<int>(list.size());
        if (scene.channels == 1) return {list[0], list[0], list[0]};
        if (scene.channels == 3) return vector(list);
        throw Unsupported(std::to_string(scene.channels) + " channels");
    }

    void camera(const json& part) {
        const std::string type = part.at("type");
        Camera& camera = scene.camera;
        if (type == "pinhole") {
            expect_fields(part, {"type", "origin", "target", "up", "fov", "width", "height"});
            camera.extent = 2 * std::tan(radians(part.at("fov")) / 2);
        } else if (type == "orthographic") {
            expect_fields(part, {"type", "origin", "target", "up", "extent", "width", "height"});
            camera.extent = part.at("extent");
            camera.parallel = true;
        } else {
            throw Unsupported(type);
        }
        camera.width = part.at("width"), camera.height = part.at("height");
        camera.look(vector(part.at("origin")), vector(part.at("target")), vector(part.at("up")));
    }

    void surface(const json& part) {
        expect_fields(part, {"name", "shape", "material", "emission"});
        const std::shared_ptr<const Bsdf> bsdf = material(part.at("material"));
        for (auto& shape : shapes(part.at("shape"))) {
            Surface surface{std::move(shape), bsdf};
            if (part.contains("emission")) {
                auto light = area_light(*surface.shape, part["emission"]);
                surface.light = light.get();
                scene.lights.push_back(std::move(light));
            }
            scene.surfaces.push_back(std::move(surface));
        }
    }

    /// One shape, or the triangles of a mesh.
    std::vector<std::unique_ptr<Shape>> shapes(const json& part) {
        const std::string type = part.at("type");
        std::vector<std::unique_ptr<Shape>> made;
        const auto flat = [&](Flat::Outline outline, Vector origin, Vector a, Vector b) {
            made.push_back(std::make_unique<Flat>(outline, origin, a, b));
        };
        const auto at = [&](const char* name) { return vector(part.at(name)); };
        if (type == "quad") {
            expect_fields(part, {"type", "corner", "edge_u", "edge_v"});
            flat(Flat::parallelogram, at("corner"), at("edge_u"), at("edge_v"));
        } else if (type == "disk") {
            expect_fields(part, {"type", "center", "axis_u", "axis_v"});
            flat(Flat::ellipse, at("center"), at("axis_u"), at("axis_v"));
        } else if (type == "sphere") {
            expect_fields(part, {"type", "center", "radius", "inward"});
            const bool inward = part.value("inward", false);
            made.push_back(std::make_unique<Sphere>(at("center"), part.at("radius"), inward));
        } else if (type == "mesh") {
            if (part.contains("normals")) throw Unsupported("shading normals");
            expect_fields(part, {"type", "vertices", "triangles", "uv"});
            const json& vertices = part.at("vertices");
            const auto corner = [&](const json& i) { return vector(vertices.at(i.get<std::size_t>())); };
            for (const json& t : part.at("triangles")) {
                const Vector a = corner(t.at(0)), b = corner(t.at(1)), c = corner(t.at(2));
                flat(Flat::triangle, a, b - a, c - a);
            }
        } else {
            throw Unsupported(type);
        }
        return made;
    }

    std::shared_ptr<const Bsdf> material(const json& part) {
        const std::string type = part.at("type");
        if (type == "lambertian") {
            expect_fields(part, {"type", "albedo"});
            if (part.at("albedo").is_object())
                throw Unsupported(part["albedo"].at("type").get<std::string>() + " texture");
            return std::make_shared<Lambertian>(colour(part["albedo"]));
        }
        if (type == "mirror") {
            expect_fields(part, {"type", "reflectance"});
            return std::make_shared<Mirror>(colour(part.at("reflectance")));
        }
        if (type == "dielectric") {
            expect_fields(part, {"type", "interior_ior", "exterior_ior"});
            const double interior = part.value("interior_ior", 1.5), exterior = part.value("exterior_ior", 1.0);
            return std::make_shared<Dielectric>(interior, exterior);
        }
        throw Unsupported(type);
    }

    std::unique_ptr<AreaLight> area_light(const Shape& shape, const json& part) {
        expect_fields(part, {"type", "radiance", "polar_range"});
        const Colour radiance = colour(part.at("radiance"));
        if (!part.contains("polar_range")) return std::make_unique<AreaLight>(shape, radiance);
        const json& zone = part["polar_range"];
        expect_fields(zone, {"low", "high", "axis"});
        const Vector axis = zone.contains("axis") ? direction(zone["axis"]) : Vector{0, 0, 1};
        const double low = std::cos(radians(zone.value("high", 180.0)));  // the larger angle, the smaller cosine
        const double high = std::cos(radians(zone.value("low", 0.0)));
        return std::make_unique<AreaLight>(dynamic_cast<const Sphere&>(shape), radiance, axis, low, high);
    }

    void light(const json& part) {
        const std::string type = part.at("type");
        const auto add = [&](auto light) { scene.lights.push_back(std::make_unique<decltype(light)>(light)); };
        if (type == "point") {
            expect_fields(part, {"type", "position", "intensity"});
            add(SpotLight(vector(part.at("position")), colour(part.at("intensity"))));
        } else if (type == "spot") {
            expect_fields(part, {"type", "position", "direction", "intensity", "cutoff", "beam"});
            const Vector position = vector(part.at("position")), axis = direction(part.at("direction"));
            const double beam = radians(part.at("beam")), cutoff = radians(part.at("cutoff"));
            add(SpotLight(position, colour(part.at("intensity")), axis, beam, cutoff));
        } else if (type == "directional") {
            expect_fields(part, {"type", "direction", "irradiance"});
            add(DirectionalLight(direction(part.at("direction")), colour(part.at("irradiance"))));
        } else if (type == "constant") {
            expect_fields(part, {"type", "radiance"});
            scene.environment = colour(part.at("radiance"));
        } else {
            throw Unsupported(type);
        }
    }

    Scene scene;
};

}  // namespace

Hit Scene::meet(const Ray& ray) const {
    Hit hit;
    for (const Surface& surface : surfaces)
        if (const double distance = surface.shape->meet(ray); distance < hit.distance)
            hit.distance = distance, hit.surface = &surface;
    if (hit.surface) {
        hit.x = ray.origin + hit.distance * ray.direction;
        hit.n = hit.surface->shape->normal(hit.x);
    }
    return hit;
}

Scene read_scene(const std::string& path) {
    std::ifstream file(path);
    if (!file) throw std::runtime_error(path + ": can't be read");
    return Reader().read(json::parse(file));
}
