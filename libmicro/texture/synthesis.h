#pragma once

#include <cstdint>

#include "texture/model.h"

namespace micro {

/// Slope coordinates of a texture, [rows, cols] each.
using TextureField = std::array<Grid<float>, kChannels>;

/// Size of a texture in texels; it goes on at its opposite border.
struct TextureSize {
  Eigen::Index rows = 512, cols = 512;
};

/// The whole texture by one inverse Fourier transform a component [Dong15 §9]: the model's amplitudes with
/// random phases, so that mean, variance and amplitude spectrum are the model's exactly. Phases are 12 bits
/// of counter-based random numbers; the texture depends on (model, size, seed) alone. Takes 40 bytes a texel.
TextureField synthesise(const TextureModel& model, const TextureSize& size, std::uint64_t seed);

/// A part of a texture of any size, in memory that goes with the part: white noise, counter-based and
/// periodic over the whole texture, convolved with the model's kernel, which ends within a margin about the
/// part. The same law as synthesise(), not the same texture: mean and variance are the model's on average.
/// Parts agree to the rounding of float32 transforms, some 1e-5 of a standard deviation.
struct TexturePart {
  Eigen::Index row = 0, col = 0, rows = 0, cols = 0;
};
TextureField synthesise_part(const TextureModel& model, const TextureSize& size, std::uint64_t seed,
                             const TexturePart& part);

}  // namespace micro
