// The camera: rays through points of the image. (0, 0) is the outer corner of the top left pixel.
#pragma once

#include "shapes.h"

struct Camera {
    bool parallel = false;  // orthographic; else all rays start in the origin
    int width = 0, height = 0;
    Vector origin, right, up, forward;
    double extent = 0;  // of the smaller axis of the image: at distance 1, or, if parallel, in the scene

    void look(Vector from, Vector target, Vector upwards) {
        origin = from;
        forward = normalised(target - from);
        right = normalised(cross(forward, upwards));
        up = cross(right, forward);
    }

    Ray ray(double x, double y) const {
        const double pixel = extent / std::min(width, height);
        const Vector offset = pixel * (x - width / 2.0) * right + pixel * (height / 2.0 - y) * up;
        if (parallel) return {origin + offset, forward};
        return {origin, normalised(forward + offset)};
    }
};
