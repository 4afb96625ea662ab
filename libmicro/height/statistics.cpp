#include "height/statistics.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>
#include <numbers>
#include <vector>

#include "core/parallel.h"
#include "height/triangles.h"

namespace micro {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index kRowsPerBlock = 32;

/// Σ over n rows of row(j), in blocks whose cut does not depend on the number of threads.
template <int Terms, typename Row>
Eigen::Array<double, Terms, 1> sum_rows(Eigen::Index n, Row&& row) {
  using Sum = Eigen::Array<double, Terms, 1>;
  std::vector<Sum> blocks(static_cast<std::size_t>((n + kRowsPerBlock - 1) / kRowsPerBlock), Sum::Zero());
  parallel_blocks(n, kRowsPerBlock, [&](Eigen::Index begin, Eigen::Index end) {
    Sum sum = Sum::Zero();
    for (Eigen::Index j = begin; j < end; ++j)
      sum += row(j);
    blocks[static_cast<std::size_t>(begin / kRowsPerBlock)] = sum;
  });
  Sum total = Sum::Zero();
  for (const Sum& block : blocks)
    total += block;
  return total;
}

/// Σ over valid points of term(z).
template <int Terms, typename Term>
Eigen::Array<double, Terms, 1> sum_points(const HeightField& surface, Term&& term) {
  using Sum = Eigen::Array<double, Terms, 1>;
  return sum_rows<Terms>(surface.rows(), [&](Eigen::Index j) {
    Sum sum = Sum::Zero();
    for (const float z : surface.z.row(j))
      if (!is_missing(z)) sum += term(static_cast<double>(z));
    return sum;
  });
}

/// Σ over triangles of term(zx, zy).
template <int Terms, typename Term>
Eigen::Array<double, Terms, 1> sum_triangles(const HeightField& surface, Term&& term) {
  using Sum = Eigen::Array<double, Terms, 1>;
  if (surface.rows() < 2) return Sum::Zero();
  return sum_rows<Terms>(surface.rows() - 1, [&](Eigen::Index j) {
    Sum sum = Sum::Zero();
    for_each_triangle(surface, j, [&](const Triangle& t) { sum += term(t.zx, t.zy); });
    return sum;
  });
}

/// Σ of 1, zx, zy, zx², zx zy, zy² over the cells with four corners, slopes averaged over opposite sides.
Eigen::Array<double, 6, 1> sum_cell_slopes(const HeightField& surface) {
  using Sum = Eigen::Array<double, 6, 1>;
  if (surface.rows() < 2) return Sum::Zero();
  return sum_rows<6>(surface.rows() - 1, [&](Eigen::Index j) {
    Sum sum = Sum::Zero();
    for (Eigen::Index i = 0; i + 1 < surface.cols(); ++i) {
      const double rising = static_cast<double>(surface.z(j + 1, i + 1)) - surface.z(j, i);
      const double falling = static_cast<double>(surface.z(j, i + 1)) - surface.z(j + 1, i);
      const double zx = (rising + falling) / (2 * surface.dx), zy = (rising - falling) / (2 * surface.dy);
      if (!std::isnan(zx)) sum += (Sum() << 1, zx, zy, zx * zx, zx * zy, zy * zy).finished();
    }
    return sum;
  });
}

/// Number of valid points, and their mean as an offset from surface.mean, µm (NaN if there are none).
struct Centre {
  double n, mean;
};

Centre centre(const HeightField& surface) {
  const auto sum = sum_points<2>(surface, [](double z) { return Eigen::Array2d(1, z); });
  return {sum(0), sum(0) > 0 ? sum(1) / sum(0) : kNone};
}

}  // namespace

HeightRange height_range(const HeightField& surface) {
  const Centre c = centre(surface);
  if (c.n == 0) return {kNone, kNone, kNone, kNone};
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (const float z : surface.z.reshaped<Eigen::RowMajor>()) {
    low = z < low ? z : low;  // false for NaN
    high = z > high ? z : high;
  }
  return {surface.mean + low, surface.mean + high, surface.mean + c.mean, Sq(surface)};
}

HeightParameters height_parameters(const HeightField& surface) {
  const Centre c = centre(surface);
  if (c.n == 0) return {kNone, kNone, kNone, kNone, kNone};
  const HeightRange range = height_range(surface);
  const Eigen::Array4d moments = sum_points<4>(surface,
                                               [&](double z) {
                                                 const double d = z - c.mean, d2 = d * d;
                                                 return Eigen::Array4d(d2, std::abs(d), d2 * d, d2 * d2);
                                               }) /
                                 c.n;
  HeightParameters p{};
  p.Sq = std::sqrt(moments(0));
  p.Sa = moments(1);
  p.Sz = range.max - range.min;
  p.Ssk = p.Sq > 0 ? moments(2) / (moments(0) * p.Sq) : kNone;
  p.Sku = p.Sq > 0 ? moments(3) / (moments(0) * moments(0)) : kNone;
  return p;
}

double Sq(const HeightField& surface) {
  const Centre c = centre(surface);
  if (c.n == 0) return kNone;
  const auto sum = sum_points<1>(
      surface, [&](double z) { return Eigen::Array<double, 1, 1>((z - c.mean) * (z - c.mean)); });
  return std::sqrt(sum(0) / c.n);
}

double Sdq(const HeightField& surface) {
  const auto sum =
      sum_triangles<2>(surface, [](double zx, double zy) { return Eigen::Array2d(1, zx * zx + zy * zy); });
  return sum(0) > 0 ? std::sqrt(sum(1) / sum(0)) : kNone;
}

double Sdr(const HeightField& surface) {
  const auto sum = sum_triangles<2>(surface, [](double zx, double zy) {
    const double g = zx * zx + zy * zy;
    return Eigen::Array2d(1, g / (1 + std::sqrt(1 + g)));  // √(1+g) − 1 without cancellation
  });
  return sum(0) > 0 ? sum(1) / sum(0) : kNone;
}

TextureDirection texture_direction(const HeightField& surface) {
  const auto sum = sum_cell_slopes(surface);
  if (sum(0) == 0) return {kNone, kNone};
  const Eigen::Array<double, 6, 1> mean = sum / sum(0);
  Eigen::Matrix2d covariance;
  covariance(0, 0) = mean(3) - mean(1) * mean(1);
  covariance(0, 1) = covariance(1, 0) = mean(4) - mean(1) * mean(2);
  covariance(1, 1) = mean(5) - mean(2) * mean(2);
  // What is left of a plane's slopes after their mean is rounding, not texture.
  const double rounding = 1e-12 * (mean(3) + mean(5));
  const double trace = covariance.trace();
  if (!(trace > rounding)) return {kNone, kNone};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance);
  TextureDirection texture{};
  texture.anisotropy = (eigen.eigenvalues()(1) - eigen.eigenvalues()(0)) / trace;
  const Eigen::Vector2d lay = eigen.eigenvectors().col(0);
  constexpr double kHalfTurn = std::numbers::pi;
  double angle = std::atan2(lay.y(), lay.x());
  if (angle > kHalfTurn / 2) angle -= kHalfTurn;
  if (angle <= -kHalfTurn / 2) angle += kHalfTurn;
  texture.direction = texture.anisotropy >= kLeastAnisotropy ? angle : kNone;
  return texture;
}

}  // namespace micro
