#pragma once

#include <cstdint>
#include <vector>

#include "distribution/disk_table.h"
#include "distribution/slope_space.h"

namespace micro {

/// What is fitted: the ellipsoid NDF or the Beckmann distribution, both with five parameters.
enum class FitModel { EllipsoidNdf, BeckmannNdf };

/// What is minimised over the nodes: Σ(D_k − D)²·dω, or Σ(ln D_k − ln D)²·dω over nodes with D_k > 0, which
/// is for the tails.
enum class Weighting { SolidAngle, Log };

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

/// A step δ = (δt_1, δt_2, δ_11, δ_21, δ_22) of a frame, measured in the frame itself: t + L·(δt_1, δt_2) and
/// L·[e^δ_11, 0; δ_21, e^δ_22]. No step leaves the frames, and what a step means does not depend on how thin,
/// turned or skewed the lobe is.
SlopeFrame moved(const SlopeFrame& frame, const Vector5& step);

/// Sums over nodes for a frame: gram·δ = gradient is the Gauss–Newton step.
struct NormalEquations {
  Matrix5 gram = Matrix5::Zero();  ///< Σ w·g·gᵀ, g = ∂D/∂δ or ∂ln D/∂δ, w = 1/max(m_z, least_mz)
  Vector5 gradient = Vector5::Zero();  ///< Σ w·r·g
  double cost = 0;                     ///< Σ w·r²
  double data = 0;                     ///< Σ w·D_k², or Σ w·(ln D_k)²
  std::int64_t nodes = 0;              ///< that count
  NormalEquations& operator+=(const NormalEquations& other);
};

/// Nodes: m_x, m_y and density, 1/sr. Scattered: `size` of each. Rows: `rows` rows of `size` nodes that share
/// their m_x, one m_y a row. Nodes off the disk don't count. `least_mz`: see DiskGrid.
struct NodeSpan {
  const double *x, *y, *density;
  std::int64_t size;
  double least_mz;
  enum class Layout { Scattered, Rows } layout = Layout::Scattered;
  std::int64_t rows = 1;
};

/// The sums over nodes, vectorised.
NormalEquations normal_equations(const NodeSpan& nodes, const SlopeFrame& frame, FitModel model,
                                 Weighting weighting);

/// The sums over all nodes of a table, which must outlive this, on all threads; they are the same for any
/// number of threads. Takes its memory when it is made.
class TableEquations {
 public:
  explicit TableEquations(const DiskTable& table);

  NormalEquations operator()(const SlopeFrame& frame, FitModel model, Weighting weighting);

  /// Σ w²r²/(1 − h)·g·gᵀ, h = w·gᵀ·inverse·g a node's leverage: the middle of the covariance that holds
  /// whatever each node's own variance is [White80; HC2 of MacKinnon85]. `inverse` is that of gram.
  Matrix5 residual_gram(const SlopeFrame& frame, FitModel model, Weighting weighting, const Matrix5& inverse);

 private:
  template <typename Kernel>
  NormalEquations over_blocks(Kernel&& kernel);

  const DiskTable& table_;
  std::vector<double> coordinate_;       // of the nodes along either axis
  std::vector<NormalEquations> blocks_;  // of rows
};

}  // namespace micro
