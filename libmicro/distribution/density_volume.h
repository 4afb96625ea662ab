#pragma once

#include <cstdint>

#include "core/fft.h"
#include "core/grid.h"

namespace micro {

/// Regular nodes in the space of q (rad/µm): q_x = i·step_x and q_y = j·step_y for |i| ≤ reach_x, |j| ≤
/// reach_y, and q_z = k·step_z for k = first_z … first_z+count_z−1. They cover |q_x|, |q_y| ≤ q_xy and 0 ≤
/// q_z ≤ q_z with kTaps/2 nodes to spare.
struct VolumeGrid {
  double step_x, step_y, step_z;
  std::int64_t reach_x, reach_y, first_z, count_z;

  std::int64_t cols() const { return 2 * reach_x + 1; }
  std::int64_t rows() const { return 2 * reach_y + 1; }
  std::int64_t size() const { return cols() * rows() * count_z; }
  bool operator==(const VolumeGrid&) const = default;
};

/// What a volume is to hold: D of patches no longer than side_x × side_y whose heights span `height` (µm),
/// for |q_x|, |q_y| ≤ q_xy and 0 ≤ q_z ≤ q_z (rad/µm): all |q| ≤ q_max with both q_max.
struct VolumeExtent {
  double side_x, side_y, height, q_xy, q_z;
};

/// The 3-D normal distribution D_K(q) of [Dong15 Eq. 8] as values on a regular grid, to be evaluated at any
/// q. Linear in D, so that means over scans are means of volumes of one grid.
///
/// D(q) = |F(q)|²/4π²A is the Fourier transform of an autocorrelation, which ends at ±side_x, ±side_y and
/// ±height (at least 20/q_z is taken: D grows as |q|²): band limited in each direction. With nodes
/// π/(kOversampling·that) apart, a sinc windowed by a Kaiser–Bessel function over kTaps nodes in each
/// direction interpolates it; its error is a relative L2 of 5e-4 (2e-4 measured) and at most ten times that
/// of the root mean square of D in the worst place, tested against `exact` at random q. Memory: 4 bytes a
/// node: (2q_xy·kOversampling·side/π)² · (q_z·kOversampling·height/π + kTaps), which for a 70 × 53 µm patch
/// of ±1.1 µm to q_max = 22.6 rad/µm (0.555 µm) is 0.5 GB, and a twentieth of it within 20 degrees of the
/// mirror direction.
class DensityVolume {
 public:
  static constexpr double kOversampling = 2;
  static constexpr int kTaps = 10;

  /// All zero. Throws InputError unless every number of `extent` is finite, sides and q_xy, q_z are positive
  /// and height is not negative, or if it takes more than `most_bytes`: the message says how many.
  explicit DensityVolume(const VolumeExtent& extent, std::int64_t most_bytes = std::int64_t{1} << 30);

  const VolumeExtent& extent() const { return extent_; }
  const VolumeGrid& grid() const { return grid_; }
  std::int64_t bytes() const { return grid_.size() * static_cast<std::int64_t>(sizeof(float)); }

  /// D in 1/sr at node (i, j, k), |i| ≤ reach_x, |j| ≤ reach_y, 0 ≤ k < count_z (q_z = (first_z + k)·step_z).
  float& at(std::int64_t i, std::int64_t j, std::int64_t k) { return values_[index(i, j, k)]; }
  float at(std::int64_t i, std::int64_t j, std::int64_t k) const { return values_[index(i, j, k)]; }

  /// D(q) in 1/sr, q in rad/µm, with D(−q) = D(q). Throws InputError beyond the extent.
  double operator()(const Vec3& q) const;

  /// Adds weight·other. Throws InputError if the grids differ.
  void add(const DensityVolume& other, double weight);
  void scale(double factor);

 private:
  std::size_t index(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>(((j + grid_.reach_y) * grid_.cols() + i + grid_.reach_x) * grid_.count_z +
                                    k);
  }
  VolumeExtent extent_;
  VolumeGrid grid_;
  FftVector<float> values_;  // [q_y, q_x, q_z]
};

/// The grid that an extent takes.
VolumeGrid volume_grid(const VolumeExtent& extent);

}  // namespace micro
