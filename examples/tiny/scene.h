// The scene, read from the project's JSON.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "bsdf.h"
#include "camera.h"
#include "lights.h"

struct Surface {
    std::unique_ptr<Shape> shape;
    std::shared_ptr<const Bsdf> bsdf;
    const AreaLight* light = nullptr;  // if it emits
};

/// Where a ray ends.
struct Hit {
    double distance = INFINITE;
    const Surface* surface = nullptr;  // none: it goes on for ever
    Vector x, n;
};

struct Scene {
    std::vector<Surface> surfaces;
    std::vector<std::unique_ptr<Light>> lights;
    Colour environment;
    Camera camera;
    int channels = 3;  // one is grey, and treated as three that are the same

    /// The first surface that a ray meets.
    Hit meet(const Ray& ray) const;
};

/// The scene has something that this program lacks.
struct Unsupported : std::runtime_error {
    using std::runtime_error::runtime_error;  // what: its name in JSON
};

Scene read_scene(const std::string& path);
