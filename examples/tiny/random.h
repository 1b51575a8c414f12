// Random numbers: PCG-XSH-RR (O'Neill 2014, PCG: a family of simple fast space-efficient algorithms).
#pragma once

#include <bit>
#include <cstdint>

/// A stream of uniform numbers in (0, 1).
///
/// Every path has a stream of its own, by seed, pixel and sample. So the same seed at two depths walks the same
/// paths, and their difference has little noise.
class Random {
public:
    Random(std::uint64_t seed, std::uint64_t pixel, std::uint64_t sample) {
        const std::uint64_t key = mixed(mixed(mixed(seed) + pixel) + sample);
        step = 2 * mixed(key) + 1;  // odd: which of the streams
        state = mixed(key + 1);
    }

    double operator()() {
        const std::uint64_t old = state;
        state = old * 6364136223846793005u + step;
        const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
        return (std::rotr(shifted, static_cast<int>(old >> 59)) + 0.5) * 0x1p-32;
    }

private:
    /// SplitMix64's finalizer (Steele et al. 2014, fig. 16), so that neighbours have nothing in common.
    static std::uint64_t mixed(std::uint64_t z) {
        z += 0x9e3779b97f4a7c15u;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }

    std::uint64_t state, step;
};
