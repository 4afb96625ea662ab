#include "height/level.h"

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

#include "core/parallel.h"

namespace micro {
namespace {

constexpr int kTerms = 6;  // 1, u, v, u² , uv, v²
using Moments = Eigen::Matrix<double, kTerms, kTerms>;
using Coefficients = Eigen::Matrix<double, kTerms, 1>;

/// Eigenvalues of the moment matrix below this fraction of the largest are undecided by the data. In centred
/// and scaled coordinates a grid's own are above 1e-2.
constexpr double kRankThreshold = 1e-12;

constexpr Eigen::Index kRowsPerBlock = 32;

int term_count(Level level) {
  switch (level) {
    case Level::None:
      return 0;
    case Level::Mean:
      return 1;
    case Level::Plane:
      return 3;
    case Level::Quadratic:
      return kTerms;
  }
  return 0;
}

/// Centred and scaled coordinate of each grid line from `first` to `last`: −1 … 1 (0 if there is just one).
Eigen::ArrayXd scaled(Eigen::Index n, Eigen::Index first, Eigen::Index last) {
  const double centre = 0.5 * static_cast<double>(first + last);
  const double half = last > first ? 0.5 * static_cast<double>(last - first) : 1;
  return (Eigen::ArrayXd::LinSpaced(n, 0, static_cast<double>(n - 1)) - centre) / half;
}

/// c(0) + c(1) u + c(2) v + c(3) u² + c(4) uv + c(5) v² over a grid with coordinates u[cols], v[rows].
struct Polynomial {
  Eigen::ArrayXd u, v;
  Coefficients c = Coefficients::Zero();
};

/// Σ z, Σ u z and Σ u² z of one row.
Eigen::Array3d row_sums(const float* z, const Eigen::ArrayXd& u) {
  constexpr Eigen::Index kLanes = 8;  // independent partial sums, so that the loop runs in vector registers
  double s0[kLanes] = {}, s1[kLanes] = {}, s2[kLanes] = {};
  Eigen::Index i = 0;
  for (; i + kLanes <= u.size(); i += kLanes)
    for (Eigen::Index k = 0; k < kLanes; ++k) {
      const double value = z[i + k], uz = u(i + k) * value;
      s0[k] += value;
      s1[k] += uz;
      s2[k] += u(i + k) * uz;
    }
  for (; i < u.size(); ++i) {
    const double value = z[i], uz = u(i) * value;
    s0[0] += value;
    s1[0] += uz;
    s2[0] += u(i) * uz;
  }
  Eigen::Array3d sums = Eigen::Array3d::Zero();
  for (Eigen::Index k = 0; k < kLanes; ++k)
    sums += Eigen::Array3d(s0[k], s1[k], s2[k]);
  return sums;
}

/// The fit to a complete grid. There 1, u, v, u² − ⟨u²⟩, uv and v² − ⟨v²⟩ are orthogonal, so each coefficient
/// is one projection; a term that vanishes on the grid (one or two lines) keeps the coefficient 0, which is
/// the minimum norm. Absent if a height is missing: the sums, NaN, are the test.
std::optional<Polynomial> fit_complete(const HeightField& surface, int terms) {
  const Eigen::Index rows = surface.rows(), cols = surface.cols();
  Polynomial fit{scaled(cols, 0, cols - 1), scaled(rows, 0, rows - 1)};
  Eigen::Array3Xd sums(3, rows);
  parallel_blocks(rows, kRowsPerBlock, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j)
      sums.col(j) = row_sums(&surface.z(j, 0), fit.u);
  });
  const double n = static_cast<double>(rows * cols);
  const double u2 = fit.u.square().mean(), v2 = fit.v.square().mean();
  const double u4 = (fit.u.square() - u2).square().mean(), v4 = (fit.v.square() - v2).square().mean();
  const Eigen::ArrayXd s0 = sums.row(0), s1 = sums.row(1), s2 = sums.row(2);
  if (!std::isfinite(s0.sum())) return std::nullopt;
  const auto project = [n](double sum, double norm) { return norm > kRankThreshold ? sum / n / norm : 0; };
  fit.c(0) = project(s0.sum(), 1);
  if (terms > 1) {
    fit.c(1) = project(s1.sum(), u2);
    fit.c(2) = project((fit.v * s0).sum(), v2);
  }
  if (terms > 3) {
    fit.c(3) = project((s2 - u2 * s0).sum(), u4);
    fit.c(4) = project((fit.v * s1).sum(), u2 * v2);
    fit.c(5) = project(((fit.v.square() - v2) * s0).sum(), v4);
    fit.c(0) -= fit.c(3) * u2 + fit.c(5) * v2;
  }
  return fit;
}

/// First and last row and column that hold a height.
struct Box {
  Eigen::Index top = 0, bottom = -1, left = 0, right = -1;
  bool empty() const { return bottom < top; }
};

Box bounding_box(const HeightField& surface) {
  Box box;
  const Eigen::Index cols = surface.cols();
  box.left = cols;
  for (Eigen::Index j = 0; j < surface.rows(); ++j) {
    const float* z = &surface.z(j, 0);
    const float* first = std::find_if_not(z, z + cols, is_missing);
    if (first == z + cols) continue;
    Eigen::Index last = cols - 1;
    while (is_missing(z[last]))
      --last;
    if (box.empty()) box.top = j;
    box.bottom = j;
    box.left = std::min(box.left, first - z);
    box.right = std::max(box.right, last);
  }
  return box;
}

/// The fit over the valid points: coordinates scaled to their bounding box, the moments of each row in
/// double, and the minimum-norm solution of the normal equations.
Polynomial fit_masked(const HeightField& surface, int terms) {
  const Box box = bounding_box(surface);
  Polynomial fit{scaled(surface.cols(), box.left, box.right), scaled(surface.rows(), box.top, box.bottom)};
  if (box.empty()) return fit;
  Eigen::Array<double, 8, Eigen::Dynamic> sums(8, surface.rows());  // Σ u⁰…u⁴, Σ z, Σ uz, Σ u²z
  parallel_blocks(surface.rows(), kRowsPerBlock, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j) {
      Eigen::Array<double, 8, 1> s = Eigen::Array<double, 8, 1>::Zero();
      for (Eigen::Index i = 0; i < surface.cols(); ++i) {
        const float height = surface.z(j, i);
        const bool there = !is_missing(height);
        const double w = there ? 1 : 0, z = there ? height : 0, u = fit.u(i), u2 = u * u;
        s += (Eigen::Array<double, 8, 1>() << w, w * u, w * u2, w * u2 * u, w * u2 * u2, z, u * z, u2 * z)
                 .finished();
      }
      sums.col(j) = s;
    }
  });
  constexpr int kPowerU[kTerms] = {0, 1, 0, 2, 1, 0}, kPowerV[kTerms] = {0, 0, 1, 0, 1, 2};
  Moments m = Moments::Zero();
  Coefficients b = Coefficients::Zero();
  for (Eigen::Index j = 0; j < surface.rows(); ++j) {
    double power_v[5] = {1};
    for (int k = 1; k < 5; ++k)
      power_v[k] = power_v[k - 1] * fit.v(j);
    for (int p = 0; p < kTerms; ++p) {
      for (int q = 0; q < kTerms; ++q)
        m(p, q) += power_v[kPowerV[p] + kPowerV[q]] * sums(kPowerU[p] + kPowerU[q], j);
      b(p) += power_v[kPowerV[p]] * sums(5 + kPowerU[p], j);
    }
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(kRankThreshold);
  solver.compute(m.topLeftCorner(terms, terms));
  fit.c.head(terms) = solver.solve(b.head(terms));
  return fit;
}

void subtract(HeightField& surface, const Polynomial& fit) {
  const Eigen::ArrayXd square = fit.c(3) * fit.u.square() + fit.c(1) * fit.u;
  parallel_blocks(surface.rows(), kRowsPerBlock, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j) {
      const double v = fit.v(j), constant = fit.c(0) + v * (fit.c(2) + v * fit.c(5)), uv = fit.c(4) * v;
      float* z = &surface.z(j, 0);
      for (Eigen::Index i = 0; i < surface.cols(); ++i)
        z[i] = static_cast<float>(z[i] - (constant + square(i) + uv * fit.u(i)));
    }
  });
}

}  // namespace

std::string_view name_of(Level level) {
  constexpr std::array<std::string_view, 4> kNames = {"none", "mean", "plane", "quadratic"};
  return kNames[static_cast<std::size_t>(level)];
}

std::optional<Level> level_from_name(std::string_view name) {
  for (const Level level : kLevels)
    if (name == name_of(level)) return level;
  return std::nullopt;
}

HeightField level(HeightField surface, Level level) {
  if (level == Level::None) return surface;
  surface.mean = 0;
  if (surface.z.size() == 0) return surface;
  const int terms = term_count(level);
  const std::optional<Polynomial> complete = fit_complete(surface, terms);
  subtract(surface, complete ? *complete : fit_masked(surface, terms));
  return surface;
}

}  // namespace micro
