#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <span>

#include "core/grid.h"

// The two inner loops of monte_carlo.h, compiled for every instruction set and picked at run time.
namespace micro::detail {

/// Cells of a tile: its points (2 × 3 × 256 × 3 floats) stay in the first-level cache.
constexpr Eigen::Index kTileRows = 8, kTileCols = 16;
constexpr std::size_t kTileTriangles = 2 * kTileRows * kTileCols;

/// The number of triangles is padded to a multiple of this, at least the lanes of any vector.
constexpr std::size_t kLanePadding = 64;

/// A handful of neighbouring triangles, one array entry each, T = float or double. A point of a triangle is
/// its corner plus β·b + γ·c, β, γ ≥ 0, β + γ ≤ 1; its height follows from the slopes. Lengths in µm,
/// relative to the tile's centre, so that phases stay small. `weight` is the projected area (µm²) times the
/// taper: 0 for padding.
template <typename T>
struct TriangleTile {
  std::size_t count = 0;  ///< padded
  Vec3 centre;
  std::uint64_t first_index = 0;  ///< random counter of the first triangle; lower 32 bits never wrap
  std::array<T, kTileTriangles> x, y, z, bx, by, cx, cy, zx, zy, weight;
};

/// One of the n² similar triangles that a triangle is cut into: barycentric coordinates (β, γ) = offset +
/// scale·(β', γ').
struct Stratum {
  std::uint64_t seed = 0;
  std::uint32_t stream = 0;  ///< one for each (n, stratum)
  double beta = 0, gamma = 0, scale = 1;
};

/// How many points come of one draw: the point itself, or it and its two cyclic rotations.
enum class PointsPerDraw { One = 1, Three = 3 };

/// Points of two independent draws for each triangle, in an order private to the kernel: room for
/// 2 · points · 3 · tile.count numbers.
void draw_points(const TriangleTile<float>& tile, const Stratum& stratum, PointsPerDraw points, float* out);
void draw_points(const TriangleTile<double>& tile, const Stratum& stratum, PointsPerDraw points, double* out);

/// Σ over triangles and points of (q·a_T)·e^{−iq·(s − centre)} for each of the two draws (not yet divided by
/// the number of points), and Σ over triangles of the squares and the product of the real and imaginary parts
/// of the difference of the draws: twice the covariance of one draw's sum, since triangles are independent.
struct DrawSums {
  std::array<std::complex<double>, 2> draw;
  double re_re = 0, re_im = 0, im_im = 0;
};
void sum_points(const TriangleTile<float>& tile, PointsPerDraw points, const float* drawn,
                std::span<const Vec3> q, std::span<DrawSums> out);
void sum_points(const TriangleTile<double>& tile, PointsPerDraw points, const double* drawn,
                std::span<const Vec3> q, std::span<DrawSums> out);

/// random_words(seed, stream, first + k) (core/random.h) for k in [0, count), many at a time: out[w·count +
/// k] is word w. count is a multiple of kLanePadding, and first + count doesn't cross a multiple of 2³².
void random_word_block(std::uint64_t seed, std::uint32_t stream, std::uint64_t first, std::size_t count,
                       std::uint32_t* out);

}  // namespace micro::detail
