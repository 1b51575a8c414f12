#include "image.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>

void write_exr(const std::string& path, int width, int height, int channels, const std::vector<Image>& images) {
    const std::vector<std::string> names =
        channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
    std::vector<std::vector<float>> planes;
    Imf::Header header(width, height);
    Imf::FrameBuffer buffer;
    for (const Image& image : images) {
        for (std::size_t c = 0; c < names.size(); ++c) {
            std::vector<float>& plane = planes.emplace_back();
            for (const Colour& pixel : image.pixels)
                plane.push_back(static_cast<float>(c == 0 ? pixel.x : c == 1 ? pixel.y : pixel.z));
            const std::string name = image.layer.empty() ? names[c] : image.layer + "." + names[c];
            header.channels().insert(name, Imf::Channel(Imf::FLOAT));
            buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(plane.data()), sizeof(float),
                                           sizeof(float) * static_cast<std::size_t>(width)));
        }
    }
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(height);
}
