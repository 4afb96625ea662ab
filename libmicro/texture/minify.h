#pragma once

#include <span>

#include "distribution/slope_space.h"
#include "texture/synthesis.h"

namespace micro {

/// The one ellipsoid that is most likely for normals drawn from several in equal parts, i.e. the least
/// Kullback–Leibler divergence of a single lobe from their mixture. Slopes of an ellipsoid have no covariance
/// to add up: each lobe stands as eighteen weighted slopes, chosen so that a lone lobe stays as it is, and
/// scatter_step is iterated until no width moves by 1e-4. It is then within some 1e-3 of a width of the best
/// one, within 1e-2 where lobes lie several widths apart (2e-2 of four such). NaN lobes (gaps) don't count;
/// NaN comes out where there is no other.
SlopeFrame minified(std::span<const SlopeFrame> lobes);

/// How far a single lobe is from the mixture, by quadrature over points of both: 0 for a lone lobe, never
/// less; to a tenth of itself.
struct Misfit {
  double divergence = 0;  ///< KL(mixture ‖ lobe) = ∫ m ln(m/l) − m + l, nats
  double rel_rms = 0;     ///< √(∫(mixture − lobe)²/∫mixture²) over slopes
};
Misfit misfit(std::span<const SlopeFrame> lobes, const SlopeFrame& lobe);

/// What averaging α_x, α_y, θ_x, θ_y, θ_z would give: the mistake that minified() is there to avoid.
SlopeFrame naive_average(std::span<const SlopeFrame> lobes);

/// The texels of a level `levels` coarser: each the minified lobe of the 2^levels × 2^levels that it covers,
/// cut at the far borders. Sizes are rounded up.
TextureField minified(const TextureField& field, int levels);

/// The same of a `field` that is itself a `level` of a texture of size `finest`: at the far borders its
/// texels cover less, and count less.
TextureField minified(const TextureField& field, int levels, const TextureSize& finest, int level);

/// Lobes that texel (row, col) covers `levels` levels finer: all of them, or every second, fourth … along
/// either axis where they are more than `most`.
std::vector<SlopeFrame> covered(const TextureField& field, int levels, Eigen::Index row, Eigen::Index col,
                                Eigen::Index most);

/// The size of a level: ⌈n/2^level⌉.
inline Eigen::Index level_size(Eigen::Index n, int level) {
  return ((n - 1) >> level) + 1;
}

/// Levels until one texel is left, the finest counted.
int level_count(const TextureSize& size);

}  // namespace micro
