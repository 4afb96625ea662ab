#include "fit/fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <numbers>
#include <optional>
#include <sstream>
#include <utility>

#include "core/error.h"
#include "distribution/scatter.h"
#include "fit/identify.h"

namespace micro {
namespace {

/// Nodes of the core: few where a pass over the whole table is cheap.
constexpr std::size_t kFewNodes = 1024, kManyNodes = 16384;
constexpr Eigen::Index kSmall = 257;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Where a descent ended.
struct Descent {
  SlopeFrame frame;
  NormalEquations equations;
  int iterations = 0;
  bool converged = false;
};

/// Where a model does not fit, Gauss–Newton's steps shrink by a constant factor ρ in one direction; the sum
/// of all that are still to come is step/(1 − ρ) [Aitken26]. 1 where two steps do not show that.
double extrapolation(const Vector5& step, const Vector5& last) {
  constexpr double kParallel = 0.9, kMostShrinking = 0.8;
  const double along = step.dot(last), rho = along / last.squaredNorm();
  return along >= kParallel * step.norm() * last.norm() && rho < kMostShrinking ? 1 / (1 - rho) : 1;
}

/// What the sums are increased by on their diagonal, for the solution to exist.
double least_damping(const NormalEquations& equations) {
  return 1e-14 * equations.gram.diagonal().maxCoeff();
}

/// Gauss–Newton's own step. A damped one is small far from any minimum, too.
Vector5 undamped_step(const NormalEquations& equations) {
  Matrix5 gram = equations.gram;
  gram.diagonal().array() += least_damping(equations);
  return gram.ldlt().solve(equations.gradient);
}

/// Levenberg–Marquardt [Marquardt63] in the frame's own coordinates; `equations_at` gives the sums for a
/// frame. It has converged when the next step would move nothing by more than `tolerance` widths, or lower
/// the cost by no more than `least_gain` of it; that step is taken unseen.
template <typename EquationsAt>
Descent descend(const SlopeFrame& start, double damping, double tolerance, EquationsAt&& equations_at,
                double least_gain = 1e-9) {
  constexpr double kLongestStep = 1, kLeastDamping = 1e-12, kMostDamping = 1e12;
  constexpr double kExtrapolatedGain = 100;  // an extrapolated step leaves less than a hundredth of it
  constexpr double kHardlyDamped = 1e-2;
  constexpr int kMost = 100;
  Descent descent{start, equations_at(start)};
  Vector5 last = Vector5::Zero();  // the step before, unless it was extrapolated
  while (descent.iterations < kMost) {
    const NormalEquations& now = descent.equations;
    Matrix5 damped = now.gram;
    damped.diagonal() += (damping * now.gram.diagonal()).cwiseMax(least_damping(now));
    Vector5 step = damped.ldlt().solve(now.gradient);
    if (!step.allFinite()) break;
    const Vector5 whole = damping < kHardlyDamped ? step : undamped_step(now);
    const double length = step.cwiseAbs().maxCoeff();
    step *= kLongestStep / std::max(length, kLongestStep);
    // Half of gradient·step is what the model of the cost would still gain.
    const double factor = last.isZero() ? 1 : extrapolation(step, last);
    const double enough = (factor > 1 ? kExtrapolatedGain : 1) * least_gain * now.cost;
    const bool done = whole.cwiseAbs().maxCoeff() <= tolerance || now.gradient.dot(whole) <= enough;
    const SlopeFrame next = moved(descent.frame, factor * step);
    last = factor > 1 ? Vector5::Zero() : step;
    ++descent.iterations;
    if (done) {
      if (damping < 1) descent.frame = next;
      descent.converged = true;
      break;
    }
    const NormalEquations there = equations_at(next);
    if (there.cost <= now.cost) {
      descent.frame = next;
      descent.equations = there;
      damping = std::max(damping / 10, kLeastDamping);
    } else {
      damping = std::min(damping * 8, kMostDamping);
      last.setZero();
    }
  }
  return descent;
}

/// Another start: the peak's place, and the scatter's shape made as narrow as the peak is high.
SlopeFrame peak_start(const TableNodes& core, const SlopeFrame& scatter) {
  const auto peak = static_cast<std::size_t>(std::max_element(core.density.begin(), core.density.end()) -
                                             core.density.begin());
  const double x = core.x[peak], y = core.y[peak], z = std::sqrt(1 - x * x - y * y);
  SlopeFrame frame = scatter;
  frame.centre = {-x / z, -y / z};
  const double determinant = std::numbers::inv_pi / (core.density[peak] * z * z * z * z);
  const double shrink = std::sqrt(determinant / (scatter.l11 * scatter.l22));
  frame.l11 *= shrink;
  frame.l21 *= shrink;
  frame.l22 *= shrink;
  return frame;
}

NodeSpan span_of(const TableNodes& nodes) {
  return {nodes.x.data(), nodes.y.data(), nodes.density.data(), static_cast<std::int64_t>(nodes.size())};
}

/// The best descent on the core's nodes. The second start is for tables that the model fits badly: several
/// lobes, a spike on a broad base.
Descent descend_on_core(const DiskTable& table, FitModel model, Weighting weighting) {
  constexpr double kDamping = 1e-3, kTolerance = 1e-3, kGood = 0.25;  // the whole table takes it from there
  const TableNodes core = core_nodes(table, table.grid.size < kSmall ? kFewNodes : kManyNodes);
  const auto equations_at = [&](const SlopeFrame& frame) {
    return normal_equations(span_of(core), frame, model, weighting);
  };
  const SlopeFrame scatter = slope_scatter(core, table.grid);
  Descent best = descend(scatter, kDamping, kTolerance, equations_at);
  if (best.equations.cost <= kGood * kGood * best.equations.data) return best;
  Descent other = descend(peak_start(core, scatter), kDamping, kTolerance, equations_at);
  other.iterations += best.iterations;
  best.iterations = other.iterations;
  return other.equations.cost < best.equations.cost ? other : best;
}

/// Full width at half maximum of the lobe's narrowest section, in nodes: the smallest singular value of
/// ∂m_xy/∂slope·L at the centre.
double nodes_across(const SlopeFrame& frame, FitModel model, const DiskGrid& grid) {
  const double to_width =
      2 * std::sqrt(model == FitModel::EllipsoidNdf ? std::numbers::sqrt2 - 1 : std::numbers::ln2);
  const Vec2& t = frame.centre;
  const double w = std::hypot(1., t.x(), t.y());
  const Eigen::Matrix2d jacobian = (Eigen::Matrix2d::Identity() - t * t.transpose() / (w * w)) / w;
  const Eigen::Matrix2d l = (Eigen::Matrix2d() << frame.l11, 0, frame.l21, frame.l22).finished();
  const Eigen::Matrix2d map = jacobian * l;
  // σ_min = |det|/σ_max, without the cancellation of a direct formula.
  const double determinant = frame.l11 * frame.l22 / (w * w * w * w);
  const double half = map.squaredNorm() / 2;
  const double largest2 = half + std::sqrt(std::max(0., half * half - determinant * determinant));
  return to_width * determinant / std::sqrt(largest2) / grid.spacing();
}

/// The core weighs nodes otherwise than the table does, which moves the minimum of a model that does not fit.
/// A sixteenth of a large table's nodes goes there first, where the lobe is wide enough for it.
Descent descend_on_strides(const Descent& start, const DiskTable& table, FitModel model,
                           Weighting weighting) {
  constexpr Eigen::Index kStride = 4;
  constexpr double kNodesAcross = 16, kDamping = 1e-6, kTolerance = 1e-3;
  if (table.grid.size < kSmall || !(nodes_across(start.frame, model, table.grid) >= kNodesAcross))
    return start;
  const TableNodes strided = strided_nodes(table, kStride);
  Descent end = descend(start.frame, kDamping, kTolerance, [&](const SlopeFrame& frame) {
    return normal_equations(span_of(strided), frame, model, weighting);
  });
  end.iterations += start.iterations;
  return end;
}

}  // namespace

std::string_view name_of(FitStatus status) {
  switch (status) {
    case FitStatus::Converged:
      return "converged";
    case FitStatus::Unresolved:
      return "unresolved";
    case FitStatus::Undetermined:
      return "undetermined";
    case FitStatus::NotConverged:
      return "not converged";
    case FitStatus::Misfit:
      return "misfit";
    case FitStatus::Empty:
      return "empty";
  }
  return "";
}

namespace {

/// Does any node on the disk hold something?
bool holds_something(const DiskTable& table) {
  const Eigen::Index n = table.grid.size;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i)
      if (table.density(j, i) > 0 && table.grid.mz2(j, i) > 0) return true;
  return false;
}

/// What is said of a table that holds nothing, if this one does.
std::optional<Fit> empty_fit(const DiskTable& table, FitModel model) {
  if (!table.density.isFinite().all()) throw InputError("the table holds a density that is not finite");
  if (holds_something(table)) return std::nullopt;
  Fit result;
  result.model = model;
  result.covariance.setConstant(kNaN);
  result.step_covariance.setConstant(kNaN);
  result.parameters = {kNaN, kNaN, kNaN, kNaN, kNaN};
  result.frame = {{kNaN, kNaN}, kNaN, kNaN, kNaN};
  result.rel_rms = result.nodes_across = kNaN;
  result.undetermined = "the table holds nothing";
  return result;
}

/// The fit at the end of a descent on the whole table.
Fit conclude(const Descent& end, TableEquations& equations, const DiskGrid& grid, FitModel model,
             Weighting weighting) {
  constexpr double kResolved = 2;
  Fit result;
  result.model = model;
  result.covariance.setConstant(kNaN);
  result.step_covariance.setConstant(kNaN);
  result.frame = end.frame;
  result.iterations = end.iterations;
  result.nodes_across = nodes_across(end.frame, model, grid);
  const NormalEquations linear =
      weighting == Weighting::SolidAngle ? end.equations : equations(end.frame, model, Weighting::SolidAngle);
  result.rel_rms = std::sqrt(linear.cost / linear.data);

  const Identified identified = identify(end.equations.gram);
  if (!identified.free.empty()) {
    result.parameters = canonical_parameters(end.frame);
    result.undetermined = identified.free;
    result.status = FitStatus::Undetermined;
    return result;
  }
  const auto n = static_cast<double>(end.equations.nodes);
  result.step_covariance = n / std::max(1., n - 5) * identified.inverse *
                           equations.residual_gram(end.frame, model, weighting, identified.inverse) *
                           identified.inverse;
  const Canonical canonical = canonical_with_covariance(end.frame, result.step_covariance);
  result.parameters = canonical.parameters;
  result.covariance = canonical.covariance;
  result.undetermined = canonical.round ? "theta_z: the lobe is round" : "";
  const bool off =
      weighting == Weighting::SolidAngle ? !(result.rel_rms < 1) : !std::isfinite(result.rel_rms);
  result.status = !end.converged                    ? FitStatus::NotConverged
                  : off                             ? FitStatus::Misfit
                  : result.nodes_across < kResolved ? FitStatus::Unresolved
                                                    : FitStatus::Converged;
  return result;
}

/// A distribution holds the energy 1 at most. A lobe between the nodes of a table may seem to hold more.
Fit with_energy_checked(Fit found, const DiskTable& table) {
  constexpr double kMost = 2;  // errors of estimated tables stay far below
  const double energy = table.density.sum() * table.grid.spacing() * table.grid.spacing();
  if (found.status == FitStatus::Unresolved || energy <= kMost) return found;
  std::ostringstream text;
  text << std::setprecision(3) << "the table holds " << energy
       << " times the energy of a distribution: its densities are not per steradian";
  found.misfit = text.str();
  if (found.status == FitStatus::Converged) found.status = FitStatus::Misfit;
  return found;
}

}  // namespace

Fit fit(const DiskTable& table, FitModel model, Weighting weighting) {
  constexpr double kDamping = 1e-6, kTolerance = 1e-6;
  if (auto empty = empty_fit(table, model)) return *empty;
  const Descent start = descend_on_strides(descend_on_core(table, model, weighting), table, model, weighting);
  TableEquations equations(table);
  const auto equations_at = [&](const SlopeFrame& frame) { return equations(frame, model, weighting); };
  Fit result = conclude(descend(start.frame, kDamping, kTolerance, equations_at), equations, table.grid,
                        model, weighting);
  result.iterations += start.iterations;
  return with_energy_checked(std::move(result), table);
}

Fit fit_from(const SlopeFrame& start, double tolerance, const DiskTable& table, FitModel model,
             Weighting weighting) {
  constexpr double kDamping = 1e-3;
  if (auto empty = empty_fit(table, model)) return *empty;
  TableEquations equations(table);
  const auto equations_at = [&](const SlopeFrame& frame) { return equations(frame, model, weighting); };
  return conclude(descend(start, kDamping, tolerance, equations_at, tolerance * tolerance), equations,
                  table.grid, model, weighting);
}

}  // namespace micro
