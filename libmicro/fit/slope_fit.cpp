#include "fit/slope_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "distribution/ellipsoid.h"
#include "distribution/scatter.h"
#include "fit/identify.h"

namespace micro {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The round lobe that the slopes are brought to, and the table that resolves it with eight nodes across out
/// to 2.9 widths.
constexpr double kRound = 0.2;
constexpr DiskGrid kTable = {33, 0.5};

/// Parts of a texel along either axis.
constexpr Eigen::Index kParts = 4;

/// Points with a normal, and the part of the texel each lies in.
struct Normals {
  WeightedSlopes slopes;
  std::vector<int> part;
};

Normals normals_of(const SlopeBlock& zx, const SlopeBlock& zy) {
  Normals normals;
  const auto most = static_cast<std::size_t>(zx.size());
  for (auto* values : {&normals.slopes.x, &normals.slopes.y})
    values->reserve(most);
  normals.part.reserve(most);
  for (Eigen::Index j = 0; j < zx.rows(); ++j)
    for (Eigen::Index i = 0; i < zx.cols(); ++i) {
      if (std::isnan(zx(j, i))) continue;
      normals.slopes.x.push_back(zx(j, i));
      normals.slopes.y.push_back(zy(j, i));
      normals.part.push_back(static_cast<int>(j * kParts / zx.rows() * kParts + i * kParts / zx.cols()));
    }
  return normals;
}

/// Median and half the interquartile range.
struct Quartiles {
  double median, half_range;
};
Quartiles quartiles(std::vector<double> values) {
  const auto at = [&](std::size_t k) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(k), values.end());
    return values[k];
  };
  const std::size_t n = values.size();
  return {at(n / 2), (at(n - 1 - n / 4) - at(n / 4)) / 2};
}

/// The most likely frame of about 500 of the slopes.
SlopeFrame start_of(const WeightedSlopes& slopes) {
  constexpr std::size_t kFew = 500;
  constexpr int kSteps = 8;
  constexpr double kQuartile = 0.5774;  // of a marginal, over its α
  const std::size_t stride = std::max<std::size_t>(1, slopes.size() / kFew);
  WeightedSlopes few;
  for (std::size_t k = 0; k < slopes.size(); k += stride) {
    few.x.push_back(slopes.x[k]);
    few.y.push_back(slopes.y[k]);
    few.weight.push_back(1);
  }
  const Quartiles x = quartiles(few.x), y = quartiles(few.y);
  SlopeFrame frame;
  frame.centre = {x.median, y.median};
  frame.l11 = std::max(x.half_range / kQuartile, kLeastWidth);
  frame.l22 = std::max(y.half_range / kQuartile, kLeastWidth);
  for (int k = 0; k < kSteps; ++k)
    frame = scatter_step(frame, few, kLeastWidth);
  return frame;
}

/// The normals' distribution in the frame where the lobe is round; beyond the disk's rim there is nothing.
DiskTable table_of(const WeightedSlopes& slopes, const SlopeFrame& frame) {
  DiskTable table = make_disk_table(kTable);
  const double share = 1 / (static_cast<double>(slopes.size()) * kTable.spacing() * kTable.spacing());
  const double last = kTable.size - 1;
  for (std::size_t k = 0; k < slopes.size(); ++k) {
    const Vec2 s = kRound * frame.whiten({slopes.x[k], slopes.y[k]});
    const double to_node = -1 / (kTable.spacing() * std::sqrt(1 + s.squaredNorm()));
    const double i = std::round(s.x() * to_node + kTable.centre()),
                 j = std::round(s.y() * to_node + kTable.centre());
    if (i >= 0 && j >= 0 && i <= last && j <= last)
      table.density(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)) += share;
  }
  return table;
}

/// outer ∘ (inner/kRound): the frame in slopes of one found in the table.
SlopeFrame carried_back(const SlopeFrame& outer, const SlopeFrame& inner) {
  SlopeFrame frame;
  frame.centre = outer.unwhiten(inner.centre / kRound);
  frame.l11 = outer.l11 * inner.l11 / kRound;
  frame.l21 = (outer.l21 * inner.l11 + outer.l22 * inner.l21) / kRound;
  frame.l22 = outer.l22 * inner.l22 / kRound;
  return frame;
}

/// Covariance of a step of the frame: H⁻¹·Σ_b s_b·s_bᵀ·H⁻¹/n² with s_b the sum over part b of each normal's
/// ∂D/∂δ/m_z less the mean, and H = ∫ ∂D/∂δ·(∂D/∂δ)ᵀ dω.
Matrix5 clustered_covariance(const Normals& normals, const SlopeFrame& outer, const SlopeFrame& inner,
                             const Matrix5& gram) {
  constexpr auto kAll = static_cast<std::size_t>(kParts * kParts);
  std::array<Vector5, kAll> sums;
  std::array<double, kAll> counts{};
  sums.fill(Vector5::Zero());
  const Ellipsoid lobe(inner);
  Vector5 total = Vector5::Zero();
  const WeightedSlopes& slopes = normals.slopes;
  constexpr std::size_t kFew = 2000;  // neighbours hardly differ
  const std::size_t stride = std::max<std::size_t>(1, slopes.size() / kFew);
  double n = 0;
  for (std::size_t k = 0; k < slopes.size(); k += stride, ++n) {
    const Vec2 slope = kRound * outer.whiten({slopes.x[k], slopes.y[k]});
    const double weight = lobe.D(normal_of(slope)) * std::sqrt(1 + slope.squaredNorm());
    const Vec2 v = inner.whiten(slope);
    const double pull = 4 / (1 + v.squaredNorm());
    const auto part = static_cast<std::size_t>(normals.part[k]);
    sums[part] += weight * (Vector5() << pull * v.x(), pull * v.y(), pull * v.x() * v.x() - 1,
                            pull * v.x() * v.y(), pull * v.y() * v.y() - 1)
                               .finished();
    counts[part] += 1;
  }
  for (const Vector5& sum : sums)
    total += sum;
  Matrix5 middle = Matrix5::Zero();
  double parts = 0;
  for (std::size_t b = 0; b < kAll; ++b) {
    if (counts[b] == 0) continue;
    const Vector5 away = sums[b] - total * (counts[b] / n);
    middle += away * away.transpose();
    ++parts;
  }
  if (parts < 2) return Matrix5::Constant(kNaN);
  const double to_integral = kTable.spacing() * kTable.spacing();
  const Matrix5 inverse = gram.inverse() / to_integral;
  return parts / (parts - 1) / (n * n) * inverse * middle * inverse;
}

}  // namespace

Fit fit_slopes(const SlopeBlock& zx, const SlopeBlock& zy) {
  const Normals normals = normals_of(zx, zy);
  if (normals.slopes.size() == 0) return fit(make_disk_table(kTable), FitModel::EllipsoidNdf);
  const SlopeFrame outer = start_of(normals.slopes);
  const DiskTable table = table_of(normals.slopes, outer);
  constexpr double kTolerance = 1e-4;  // widths; a texel's own error is some percent
  Fit result = fit_from({{0, 0}, kRound, 0, kRound}, kTolerance, table, FitModel::EllipsoidNdf);
  const SlopeFrame inner = result.frame;
  result.frame = carried_back(outer, inner);
  result.frame.l11 = std::max(result.frame.l11, kLeastWidth);
  result.frame.l22 = std::max(result.frame.l22, kLeastWidth);
  result.parameters = canonical_parameters(result.frame);
  result.covariance.setConstant(kNaN);
  result.step_covariance.setConstant(kNaN);
  if (result.status == FitStatus::Undetermined) return result;
  TableEquations equations(table);
  const Matrix5 gram = equations(inner, FitModel::EllipsoidNdf, Weighting::SolidAngle).gram;
  result.step_covariance = clustered_covariance(normals, outer, inner, gram);
  result.undetermined.clear();
  if (result.step_covariance.allFinite()) {
    const Canonical canonical = canonical_with_covariance(result.frame, result.step_covariance);
    result.covariance = canonical.covariance;
    result.undetermined = canonical.meaningless;
  }
  return result;
}

}  // namespace micro
