#include "height/statistics.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>
#include <numbers>
#include <vector>

#include "core/parallel.h"

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

/// How many values were there, and their sum.
using CountAndSum = Eigen::Array2d;

/// Counts and sums value(i) over i in [0, n), leaving out NaN. The independent partial sums and the selection
/// instead of a branch let the loop run in vector registers.
template <typename Value>
CountAndSum sum_valid(Eigen::Index n, Value&& value) {
  constexpr Eigen::Index kLanes = 8;
  double count[kLanes] = {}, sum[kLanes] = {};
  const auto add = [&](Eigen::Index lane, double x) {
    count[lane] += x == x ? 1. : 0.;
    sum[lane] += x == x ? x : 0.;
  };
  Eigen::Index i = 0;
  for (; i + kLanes <= n; i += kLanes)
    for (Eigen::Index k = 0; k < kLanes; ++k)
      add(k, value(i + k));
  for (; i < n; ++i)
    add(0, value(i));
  CountAndSum total = CountAndSum::Zero();
  for (Eigen::Index k = 0; k < kLanes; ++k)
    total += CountAndSum(count[k], sum[k]);
  return total;
}

/// Number of valid points and Σ term(z) over them.
template <typename Term>
CountAndSum sum_points(const HeightField& surface, Term&& term) {
  return sum_rows<2>(surface.rows(), [&](Eigen::Index j) {
    const float* z = &surface.z(j, 0);
    return sum_valid(surface.cols(), [&](Eigen::Index i) { return term(static_cast<double>(z[i])); });
  });
}

/// Number of triangles and Σ term(|∇z|²) over them: the triangles of for_each_triangle, whose gradient is NaN
/// where a corner is missing.
template <typename Term>
CountAndSum sum_triangles(const HeightField& surface, Term&& term) {
  if (surface.rows() < 2 || surface.cols() < 2) return CountAndSum::Zero();
  const double per_dx = 1 / surface.dx, per_dy = 1 / surface.dy;
  return sum_rows<2>(surface.rows() - 1, [&](Eigen::Index j) {
    const float *z0 = &surface.z(j, 0), *z1 = &surface.z(j + 1, 0);
    const auto squared = [](double slope) { return slope * slope; };
    const auto lower = [&](Eigen::Index i) {
      const double a = z0[i], b = z0[i + 1], c = z1[i + 1];
      return term(squared((b - a) * per_dx) + squared((c - b) * per_dy));
    };
    const auto upper = [&](Eigen::Index i) {
      const double a = z0[i], c = z1[i + 1], d = z1[i];
      return term(squared((c - d) * per_dx) + squared((d - a) * per_dy));
    };
    return CountAndSum(sum_valid(surface.cols() - 1, lower) + sum_valid(surface.cols() - 1, upper));
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
  const CountAndSum sum = sum_points(surface, [](double z) { return z; });
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
  const auto moment = [&](auto&& power) {
    return sum_points(surface, [&](double z) { return power(z - c.mean); })(1) / c.n;
  };
  const double m2 = moment([](double d) { return d * d; });
  HeightParameters p{};
  p.Sq = std::sqrt(m2);
  p.Sa = moment([](double d) { return std::abs(d); });
  p.Sz = range.max - range.min;
  p.Ssk = p.Sq > 0 ? moment([](double d) { return d * d * d; }) / (m2 * p.Sq) : kNone;
  p.Sku = p.Sq > 0 ? moment([](double d) { return d * d * d * d; }) / (m2 * m2) : kNone;
  return p;
}

double Sq(const HeightField& surface) {
  const Centre c = centre(surface);
  if (c.n == 0) return kNone;
  const CountAndSum sum = sum_points(surface, [&](double z) { return (z - c.mean) * (z - c.mean); });
  return std::sqrt(sum(1) / c.n);
}

double Sdq(const HeightField& surface) {
  const CountAndSum sum = sum_triangles(surface, [](double g) { return g; });
  return sum(0) > 0 ? std::sqrt(sum(1) / sum(0)) : kNone;
}

double Sdr(const HeightField& surface) {
  // √(1 + g) − 1 without cancellation.
  const CountAndSum sum = sum_triangles(surface, [](double g) { return g / (1 + std::sqrt(1 + g)); });
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
