#pragma once

#include <Eigen/Core>
#include <array>

#include "core/grid.h"
#include "distribution/slope_coordinates.h"

namespace micro {

/// Channels of a texture: the five slope coordinates.
inline constexpr std::size_t kChannels = 5;
using Covariance = Eigen::Matrix<double, 5, 5>;

/// A measured grid of lobes in slope coordinates, [rows, cols] each; NaN where there is none. Strips lie in
/// it as rows or columns; a cross of two strips is a grid with gaps.
struct Exemplar {
  std::array<Grid<double>, kChannels> channels;

  Eigen::Index rows() const { return channels[0].rows(); }
  Eigen::Index cols() const { return channels[0].cols(); }
  bool there(Eigen::Index j, Eigen::Index i) const { return !std::isnan(channels[0](j, i)); }
};

/// An exemplar of gaps.
Exemplar make_exemplar(Eigen::Index rows, Eigen::Index cols);

/// Mean and covariance over the texels that are there (divided by their number).
struct ExemplarMoments {
  SlopeCoordinates mean{};
  Covariance covariance = Covariance::Zero();
  std::int64_t count = 0;
};
ExemplarMoments moments_of(const Exemplar& exemplar);

/// Whether it is a block, more than strips: at least 2 × 2, and half of it there.
bool is_block(const Exemplar& exemplar);
/// Throws InputError unless so many texels of rows × cols are one.
void require_block(Eigen::Index rows, Eigen::Index cols, std::int64_t there);

/// What is done to a strip's or block's ends before its spectrum is taken; the mean is removed in any case
/// and a trend is left in, since slow variation is what is measured.
enum class Taper {
  None,  ///< as [Dong15 §9]: ends that don't meet leak as 1/f
  Hann,  ///< cos² over each run of at least kLeastTapered texels: leaks as 1/f³, resolves half as well
};
constexpr Eigen::Index kLeastTapered = 8;

/// The taper over n texels.
Eigen::ArrayXd taper_weights(Eigen::Index n, Taper taper);

/// Deviations of one strip's texels from the exemplar's mean, tapered; 0 where there is no texel.
Eigen::ArrayXd strip_deviations(const Eigen::ArrayXd& values, double mean, Taper taper);

}  // namespace micro
