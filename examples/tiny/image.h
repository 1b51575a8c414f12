// Images in OpenEXR files: 32-bit floats, row 0 at the top.
#pragma once

#include <string>
#include <vector>

#include "vector.h"

struct Image {
    std::string layer;           // empty for an image that is alone in its file
    std::vector<Colour> pixels;  // row by row
};

/// Write images of the same size; three channels R, G, B each, or one, Y.
void write_exr(const std::string& path, int width, int height, int channels, const std::vector<Image>& images);
