#include "fit/fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <numbers>
#include <optional>
#include <sstream>

#include "core/error.h"
#include "distribution/scatter.h"
#include "fit/identify.h"
#include "fit/overlap.h"
#include "fit/quadric_start.h"

namespace micro {
namespace {

/// Nodes of the core: few where a pass over the whole table is cheap.
constexpr std::size_t kFewNodes = 1024, kManyNodes = 16384;
constexpr Eigen::Index kSmall = 257;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Steps on a few nodes are cheap; on a large table what needs more is no lobe, or one that falls between the
/// nodes, whose widths further steps would not tell.
constexpr int kMostSteps = 100, kMostOnLarge = 20, kMostUnresolved = 10;
constexpr double kResolved = 2;  // nodes across

/// When a descent has converged: when the next step would move nothing by more than `tolerance` widths, or
/// lower the cost by no more than `least_gain` of it.
struct Accuracy {
  double tolerance, least_gain = 1e-9;
  int most = kMostSteps;
};

/// Where a descent ended.
struct Descent {
  SlopeFrame frame;
  NormalEquations equations;
  int iterations = 0;
  bool converged = false;
};

/// Where a descent may start, and what the Gram matrix lacks of the cost's curvature there, where known.
struct Start {
  SlopeFrame frame;
  Matrix5 lacking = Matrix5::Zero();
  int iterations = 0;  ///< that it took
};

/// What the Gram matrix lacks of the cost's curvature where a model does not fit, from the change of the
/// gradient over a step: the least change of S with (gram + S)·step = drop, sized [Dennis81].
/// `drop` is the gradient before less that after, `gram` that after.
Matrix5 with_secant(const Matrix5& secant, const Matrix5& gram, const Vector5& step, const Vector5& drop) {
  constexpr double kLongest = 0.5;  // widths; the frames at both ends of a longer step differ too much
  const double along = drop.dot(step);
  if (!(along > 0) || step.cwiseAbs().maxCoeff() > kLongest) return Matrix5::Zero();
  const Vector5 lacking = drop - gram * step, had = secant * step;
  const double size = std::abs(step.dot(had));
  const double factor = size > 0 ? std::min(1., std::abs(step.dot(lacking)) / size) : 1;
  const Vector5 change = lacking - factor * had;
  const Matrix5 both = change * drop.transpose();
  return factor * secant + (both + both.transpose()) / along -
         change.dot(step) / (along * along) * drop * drop.transpose();
}

/// The same near a minimum from differences of the gradient: six more sums.
template <typename EquationsAt>
Matrix5 lacking_curvature(const SlopeFrame& frame, EquationsAt&& equations_at) {
  constexpr double kStep = 1e-4;  // widths
  const NormalEquations here = equations_at(frame);
  Matrix5 curvature;
  for (int k = 0; k < 5; ++k)
    curvature.col(k) =
        (here.gradient - equations_at(moved(frame, kStep * Vector5::Unit(k))).gradient) / kStep;
  return (curvature + curvature.transpose()) / 2 - here.gram;
}

/// Levenberg–Marquardt [Marquardt63] in the frame's own coordinates with the curvature that the Gram matrix
/// lacks; `equations_at` gives the sums for a frame. The step that is found small enough is taken unseen.
template <typename EquationsAt>
Descent descend(const Start& start, double damping, const Accuracy& accuracy, EquationsAt&& equations_at) {
  constexpr double kLongestStep = 1, kLeastDamping = 1e-12, kMostDamping = 1e12, kSingular = 1e-14;
  constexpr double kHardlyDamped = 1e-2;
  Descent descent{start.frame, equations_at(start.frame)};
  Matrix5 secant = start.lacking, trusted = secant;
  while (descent.iterations < accuracy.most) {
    const NormalEquations& now = descent.equations;
    const Vector5 diagonal = now.gram.diagonal();
    const auto step_of = [&](double damped) -> Vector5 {
      Matrix5 curvature = now.gram + trusted;
      const Vector5 added = (damped * diagonal).cwiseMax(kSingular * diagonal.maxCoeff());
      curvature.diagonal() += added;
      const Eigen::LDLT<Matrix5> solver(curvature);
      if (solver.isPositive() && solver.vectorD().minCoeff() > 0) return solver.solve(now.gradient);
      curvature = now.gram;
      curvature.diagonal() += added;
      return curvature.ldlt().solve(now.gradient);
    };
    Vector5 step = step_of(damping);
    if (!step.allFinite()) break;
    // A damped step is small far from any minimum, too.
    const Vector5 whole = damping < kHardlyDamped ? step : step_of(0);
    step *= kLongestStep / std::max(step.cwiseAbs().maxCoeff(), kLongestStep);
    // Half of gradient·step is what the model of the cost would still gain.
    const bool done = whole.cwiseAbs().maxCoeff() <= accuracy.tolerance ||
                      now.gradient.dot(whole) <= accuracy.least_gain * now.cost;
    const SlopeFrame next = moved(descent.frame, step);
    ++descent.iterations;
    if (done) {
      if (damping < 1) descent.frame = next;
      descent.converged = true;
      break;
    }
    const NormalEquations there = equations_at(next);
    // It is trusted where it foretold the last step's gain as well as the Gram matrix alone would have.
    const double surprise = there.cost - now.cost + step.dot(2 * now.gradient - now.gram * step);
    const bool foretold = std::abs(surprise - step.dot(secant * step)) <= std::abs(surprise);
    secant = with_secant(secant, there.gram, step, now.gradient - there.gradient);
    trusted = foretold ? secant : Matrix5::Zero();
    if (there.cost <= now.cost) {
      descent.frame = next;
      descent.equations = there;
      damping = std::max(damping / 10, kLeastDamping);
    } else {
      damping = std::min(damping * 8, kMostDamping);
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
  return {nodes.x.data(), nodes.y.data(), nodes.density.data(), static_cast<std::int64_t>(nodes.size()),
          nodes.least_mz};
}

/// The best descent on the core's nodes, from the scatter or from the quadric that fits it. Another start is
/// for tables that the model fits badly: several lobes, a spike on a broad base.
Descent descend_on_core(const DiskTable& table, FitModel model, Weighting weighting) {
  constexpr double kDamping = 1e-3, kGood = 0.25;
  constexpr Accuracy kRough{.tolerance = 1e-3};  // the whole table takes it from there
  const TableNodes core = core_nodes(table, table.grid.size < kSmall ? kFewNodes : kManyNodes);
  const auto equations_at = [&](const SlopeFrame& frame) {
    return normal_equations(span_of(core), frame, model, weighting);
  };
  const SlopeFrame scatter = slope_scatter(core, table.grid);
  const auto quadric = quadric_start(core, scatter, model, weighting);
  const bool by_quadric = quadric && equations_at(*quadric).cost < equations_at(scatter).cost;
  Descent best = descend({by_quadric ? *quadric : scatter}, kDamping, kRough, equations_at);
  if (best.equations.cost <= kGood * kGood * best.equations.data) return best;
  Descent other = descend({peak_start(core, scatter)}, kDamping, kRough, equations_at);
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
/// A part of a large table's nodes goes there first: a sixteenth where the lobe is wide enough for it, or
/// where the tails decide; a quarter where it is half as wide. Their curvature serves for all nodes.
Start descend_on_strides(const Descent& start, const DiskTable& table, FitModel model, Weighting weighting) {
  constexpr double kNodesAcross = 4, kDamping = 1e-6;  // nodes left across the lobe
  constexpr Accuracy kFair{.tolerance = 1e-4, .most = 50};
  const double across = nodes_across(start.frame, model, table.grid) / kNodesAcross;
  const Eigen::Index stride = weighting == Weighting::Log || across >= 4 ? 4 : across >= 2 ? 2 : 1;
  if (table.grid.size < kSmall || stride == 1) return {.frame = start.frame, .iterations = start.iterations};
  const TableNodes strided = strided_nodes(table, stride);
  const auto equations_at = [&](const SlopeFrame& frame) {
    return normal_equations(span_of(strided), frame, model, weighting);
  };
  const Descent end = descend({start.frame}, kDamping, kFair, equations_at);
  const auto nodes_each = static_cast<double>(stride * stride);
  return {end.frame, nodes_each * lacking_curvature(end.frame, equations_at),
          start.iterations + end.iterations};
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

/// Does any node on the disk hold something, whose square is a number?
bool holds_something(const DiskTable& table) {
  constexpr double kNothing = 1e-140;
  const Eigen::Index n = table.grid.size;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i)
      if (table.density(j, i) > kNothing && table.grid.mz2(j, i) > 0) return true;
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
  result.rel_rms = result.overlap = result.nodes_across = kNaN;
  result.undetermined = "the table holds nothing";
  return result;
}

/// What is wrong with a lobe or its table, in words. A distribution holds the energy 1 at most; a lobe
/// between the nodes of a table, or at the horizon, may seem to hold more, and so does its table.
std::string misfit_of(const Fit& fit, const DiskTable& table) {
  constexpr double kMostEnergy = 2;  // errors of estimated tables stay far below
  constexpr double kLeastOverlap = 0.5;
  const double energy = table.density.sum() * table.grid.spacing() * table.grid.spacing();
  std::ostringstream text;
  text << std::setprecision(3);
  if (fit.overlap >= kLeastOverlap) return "";
  if (energy > kMostEnergy)
    text << "the table holds " << energy
         << " times the energy of a distribution: its densities are not per steradian";
  else
    text << "of the energy only the part " << fit.overlap << " is where the lobe has it";
  return text.str();
}

/// The fit at the end of a descent on the whole table.
Fit conclude(const Descent& end, TableEquations& equations, const DiskTable& table, FitModel model,
             Weighting weighting) {
  Fit result;
  result.model = model;
  result.covariance.setConstant(kNaN);
  result.step_covariance.setConstant(kNaN);
  result.frame = end.frame;
  result.iterations = end.iterations;
  result.nodes_across = nodes_across(end.frame, model, table.grid);
  const NormalEquations linear =
      weighting == Weighting::SolidAngle ? end.equations : equations(end.frame, model, Weighting::SolidAngle);
  result.rel_rms = std::sqrt(linear.cost / linear.data);
  result.overlap = overlap(table, end.frame, model, result.nodes_across);
  result.misfit = misfit_of(result, table);

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
  result.undetermined = canonical.meaningless;
  const std::string barely = barely_known(result.step_covariance).words;
  result.undetermined += (barely.empty() || result.undetermined.empty() ? "" : "; ") + barely;
  // Where the lobe falls between the nodes steps may wander for ever, within a node.
  const bool unresolved = result.nodes_across < kResolved && result.misfit.empty();
  result.status = unresolved               ? FitStatus::Unresolved
                  : !end.converged         ? FitStatus::NotConverged
                  : !result.misfit.empty() ? FitStatus::Misfit
                                           : FitStatus::Converged;
  return result;
}

}  // namespace

Fit fit(const DiskTable& table, FitModel model, Weighting weighting) {
  constexpr double kDamping = 1e-6, kTolerance = 1e-6;
  constexpr double kKnown = 1;  // width
  if (auto empty = empty_fit(table, model)) return *empty;
  const Start start = descend_on_strides(descend_on_core(table, model, weighting), table, model, weighting);
  TableEquations equations(table);
  const auto equations_at = [&](const SlopeFrame& frame) { return equations(frame, model, weighting); };
  const bool resolved = weighting == Weighting::Log ||  // tails tell of the width
                        nodes_across(start.frame, model, table.grid) >= kResolved / 2;
  const Accuracy accuracy{.tolerance = kTolerance,
                          .most = table.grid.size < kSmall ? kMostSteps
                                  : resolved               ? kMostOnLarge
                                                           : kMostUnresolved};
  Fit result = conclude(descend(start, kDamping, accuracy, equations_at), equations, table, model, weighting);
  result.iterations += start.iterations;
  if (result.status == FitStatus::Converged && !(barely_known(result.step_covariance).error <= kKnown))
    result.status = FitStatus::Undetermined;
  return result;
}

Fit fit_from(const SlopeFrame& start, double tolerance, const DiskTable& table, FitModel model,
             Weighting weighting) {
  constexpr double kDamping = 1e-3;
  if (auto empty = empty_fit(table, model)) return *empty;
  TableEquations equations(table);
  const auto equations_at = [&](const SlopeFrame& frame) { return equations(frame, model, weighting); };
  const Accuracy accuracy{.tolerance = tolerance, .least_gain = tolerance * tolerance};
  return conclude(descend({start}, kDamping, accuracy, equations_at), equations, table, model, weighting);
}

}  // namespace micro
