#pragma once

#include <string>
#include <string_view>

#include "fit/normal_equations.h"

namespace micro {

/// How a fit ended.
enum class FitStatus {
  Converged,     ///< a minimum was reached, and the table determines all that it was asked for
  Unresolved,    ///< the lobe is narrower than two nodes: widths are uncertain by about a node
  Undetermined,  ///< a combination of the parameters is free, or known to no better than a width
  NotConverged,  ///< the steps ran out
  Misfit,        ///< a minimum, but less than half of the energy is where the lobe has it, see `overlap`
  Empty,         ///< the table holds nothing
};
std::string_view name_of(FitStatus status);

/// A distribution fitted to a table. Where the status is Empty the numbers are NaN.
struct Fit {
  FitModel model = FitModel::EllipsoidNdf;
  FitStatus status = FitStatus::Empty;
  SlopeFrame frame;                ///< location and scale in slope space
  EllipsoidParameters parameters;  ///< the same as canonical widths and angles; angles without meaning are 0
  /// Covariance of (α_x, α_y, θ_x, θ_y, θ_z); NaN in the row and column of what is not determined.
  Matrix5 covariance;
  Matrix5 step_covariance;  ///< covariance of a step δ of the frame, see moved()
  double rel_rms = 0;  ///< √(Σ(D_k − D)²dω / ΣD_k²dω); speckle alone makes it 0.7, sparse counts 1
  double overlap = 0;  ///< how much of the energy table and lobe have in the same places, see overlap()
  int iterations = 0;  ///< on the nodes of the core, on a part, and on the whole table
  double nodes_across = 0;   ///< full width at half maximum of the lobe's narrowest section, in nodes
  std::string undetermined;  ///< what the table cannot tell, in words; empty if nothing
  std::string misfit;        ///< what is wrong with lobe or table, in words; empty if nothing
};

/// Fits five parameters to a table by Levenberg–Marquardt, started from the quantiles of the table's core.
/// The model is compared by its value at the nodes; a histogram's node holds the mean over its bin, which
/// makes a lobe of n nodes look wider by a part of about 1/(6n²). Densities are taken as they are, so a table
/// that holds a part of the energy, or ends before the lobe does, is fitted as that part. The covariance is
/// that of independent nodes, of any variances; where the model does not fit, it says how well the best fit
/// is determined, not how far off it is. It holds to first order: a lobe far longer than the table errs by
/// more along its length, and `undetermined` says so from a tenth of a width on.
///
/// A minimum is no success by itself: unless the table has half of its energy where the lobe has it, the
/// model is not what the table shows (the status is Misfit). By logarithms the far tails decide, which a
/// Gaussian model of an ellipsoid's table cannot follow: that ends so.
///
/// Throws InputError if a density is not finite. No memory is taken while it iterates.
Fit fit(const DiskTable& table, FitModel model, Weighting weighting = Weighting::SolidAngle);

/// The same from a start that is known to be good, until no step would move anything by more than `tolerance`
/// widths or lower the cost by more than tolerance² of it.
Fit fit_from(const SlopeFrame& start, double tolerance, const DiskTable& table, FitModel model,
             Weighting weighting = Weighting::SolidAngle);

}  // namespace micro
