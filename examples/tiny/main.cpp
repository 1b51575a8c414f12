// tiny: a path tracer for the scenes of Lightproof.
//
//     tiny scene.json --spp 64 --seed 1 --bounces 5 -o image.exr
//
// --bounces n     E + TE + … + TⁿE; without it all bounces, ended by Russian roulette
// --layers        with --bounces: each bounce as a layer, bounce0, bounce1, …, instead of their sum
// --version       nothing but the version
//
// Exit status: 0 done, 1 failed, 2 wrong usage, 3 the scene has something that tiny lacks. The last line on the
// standard error then says what: "unsupported: conductor".

#include <charconv>
#include <iostream>
#include <string_view>

#include "image.h"
#include "path_tracer.h"

namespace {

/// Arguments that can't be.
struct Usage : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct Options {
    std::string scene, out;
    std::uint64_t spp = 16, seed = 0;
    std::optional<int> bounces;
    bool layers = false, version = false;
};

template <typename Number>
Number number(const std::string& option, std::string_view text, Number least) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value < least)
        throw Usage(option + " " + std::string(text) + ": expected a whole number, " + std::to_string(least) +
                    " or more");
    return value;
}

Options parsed(const std::vector<std::string>& arguments) {
    Options options;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const std::string& name = arguments[i];
        const auto value = [&]() -> const std::string& {
            if (++i == arguments.size()) throw Usage(name + ": expected a value");
            return arguments[i];
        };
        if (name == "--spp") options.spp = number<std::uint64_t>(name, value(), 1);
        else if (name == "--seed") options.seed = number<std::uint64_t>(name, value(), 0);
        else if (name == "--bounces") options.bounces = number<int>(name, value(), 0);
        else if (name == "--layers") options.layers = true;
        else if (name == "--version") options.version = true;
        else if (name == "-o") options.out = value();
        else if (name.starts_with("-") || !options.scene.empty()) throw Usage(name + ": no such option");
        else options.scene = name;
    }
    if (options.version) return options;
    if (options.scene.empty() || options.out.empty()) throw Usage("expected a scene and -o FILE");
    if (options.layers && !options.bounces) throw Usage("--layers: expected --bounces as well");
    return options;
}

/// An image per bounce, or their sum.
std::vector<Image> rendered(const Scene& scene, const Options& options) {
    const auto width = static_cast<std::size_t>(scene.camera.width);
    const auto height = static_cast<std::size_t>(scene.camera.height);
    const std::size_t count = options.layers ? static_cast<std::size_t>(*options.bounces) + 1 : 1;
    std::vector<Image> images(count, Image{"", std::vector<Colour>(width * height)});
    if (options.layers)
        for (std::size_t k = 0; k < count; ++k) images[k].layer = "bounce" + std::to_string(k);

    const PathTracer tracer(scene, options.bounces);
    std::vector<Colour> terms;
    for (std::size_t pixel = 0; pixel < width * height; ++pixel) {
        terms.assign(count, {});
        for (std::uint64_t i = 0; i < options.spp; ++i) {
            Random random(options.seed, pixel, i);
            // anywhere in the square of the pixel: the box filter
            const double x = static_cast<double>(pixel % width) + random();
            const double y = static_cast<double>(pixel / width) + random();
            tracer.walk(scene.camera.ray(x, y), random, terms);
        }
        for (std::size_t k = 0; k < terms.size(); ++k)
            images[options.layers ? k : 0].pixels[pixel] += 1 / static_cast<double>(options.spp) * terms[k];
    }
    return images;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const Options options = parsed({argv + 1, argv + argc});
        if (options.version) {
            std::cout << "tiny 1.0\n";
            return 0;
        }
        const Scene scene = read_scene(options.scene);
        const std::vector<Image> images = rendered(scene, options);
        write_exr(options.out, scene.camera.width, scene.camera.height, scene.channels, images);
        return 0;
    } catch (const Usage& error) {
        std::cerr << "tiny: " << error.what() << '\n'
                  << "usage: tiny scene.json [--spp N] [--seed S] [--bounces N [--layers]] -o image.exr\n";
        return 2;
    } catch (const Unsupported& feature) {
        std::cerr << "unsupported: " << feature.what() << '\n';
        return 3;
    } catch (const std::exception& error) {
        std::cerr << "tiny: " << error.what() << '\n';
        return 1;
    }
}
