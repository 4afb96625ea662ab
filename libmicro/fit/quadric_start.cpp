#include "fit/quadric_start.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace micro {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// One node's equation row·a = value, for the quadric a = (a_11, a_12, a_22, a_1, a_2, a_0) in (v_1, v_2).
struct Equation {
  Vector6 row;
  double value;
};

/// (v_1, v_2)·m_z and m_z of a normal: finite at the horizon, where slopes are not.
Equation equation_of(const Vec3& u, double density, FitModel model, Weighting weighting) {
  const double x = u.x(), y = u.y(), z = u.z();
  const Vector6 quadratic = (Vector6() << x * x, x * y, y * y, x * z, y * z, z * z).finished();
  // dD = −2·D^{3/2}·d(D^{−1/2}) = −D·d(−ln D); by logarithms, dD/D.
  const bool linear = weighting == Weighting::SolidAngle;
  if (model == FitModel::EllipsoidNdf) {
    const double weight = linear ? density * std::sqrt(density) : std::sqrt(density);
    return {weight * quadratic, linear ? density : 1};
  }
  const double weight = linear ? density : 1;
  return {weight / (z * z) * quadratic, -weight * std::log(density * z * z * z * z)};
}

/// The frame of the quadric in the coordinates of another frame.
std::optional<SlopeFrame> frame_of(const Vector6& a, const SlopeFrame& near, FitModel model) {
  const Eigen::Matrix2d p = (Eigen::Matrix2d() << a[0], a[1] / 2, a[1] / 2, a[2]).finished();
  const Eigen::LLT<Eigen::Matrix2d> cholesky(p);
  if (!p.allFinite() || cholesky.info() != Eigen::Success) return std::nullopt;
  const Vec2 centre = -cholesky.solve(Vec2(a[3], a[4])) / 2;
  const double least = a[5] + centre.dot(Vec2(a[3], a[4])) / 2;
  // (v − v_0)ᵀP(v − v_0)/least = |C⁻¹(v − v_0)|², and CCᵀ = least·P⁻¹.
  const double height = model == FitModel::EllipsoidNdf ? least : 1;
  if (!(height > 0)) return std::nullopt;
  const Eigen::Matrix2d scale = height * cholesky.solve(Eigen::Matrix2d::Identity());
  const double c11 = std::sqrt(scale(0, 0)), c21 = scale(1, 0) / c11;
  const double c22 = std::sqrt(height / (p(1, 1)));  // = √(|scale|)/c11, without its cancellation
  SlopeFrame frame;
  frame.centre = near.unwhiten(centre);
  frame.l11 = near.l11 * c11;
  frame.l21 = near.l21 * c11 + near.l22 * c21;
  frame.l22 = near.l22 * c22;
  const bool finite = std::isfinite(frame.centre.sum()) && std::isfinite(frame.l21);
  return finite && frame.l11 > 0 && frame.l22 > 0 && std::isfinite(frame.l11 * frame.l22)
             ? std::optional(frame)
             : std::nullopt;
}

std::optional<SlopeFrame> solve(const TableNodes& nodes, double unit, const SlopeFrame& near, FitModel model,
                                Weighting weighting) {
  Matrix6 gram = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  const double i11 = 1 / near.l11, i22 = 1 / near.l22;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (!(nodes.density[k] > 0)) continue;
    const double z = std::sqrt(1 - nodes.x[k] * nodes.x[k] - nodes.y[k] * nodes.y[k]);
    const double v1 = (-nodes.x[k] - near.centre.x() * z) * i11,
                 v2 = (-nodes.y[k] - near.centre.y() * z - near.l21 * v1) * i22;
    const Equation equation = equation_of({v1, v2, z}, nodes.density[k] / unit, model, weighting);
    const double solid_angle = 1 / std::max(z, nodes.least_mz);
    gram.selfadjointView<Eigen::Lower>().rankUpdate(equation.row, solid_angle);
    right += solid_angle * equation.value * equation.row;
  }
  gram = gram.selfadjointView<Eigen::Lower>();
  const Vector6 scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Vector6 a = scale.asDiagonal() *
                    (scale.asDiagonal() * gram * scale.asDiagonal()).ldlt().solve(scale.asDiagonal() * right);
  return frame_of(a, near, model);
}

}  // namespace

std::optional<SlopeFrame> quadric_start(const TableNodes& nodes, const SlopeFrame& near, FitModel model,
                                        Weighting weighting) {
  if (nodes.density.empty()) return std::nullopt;
  // Powers of densities stay near one.
  const double unit = *std::max_element(nodes.density.begin(), nodes.density.end());
  if (!(unit > 0)) return std::nullopt;
  // In the coordinates of what is found its six unknowns are as independent as they can be.
  constexpr int kPasses = 3;
  SlopeFrame frame = near;
  for (int pass = 0; pass < kPasses; ++pass) {
    const auto next = solve(nodes, unit, frame, model, weighting);
    if (!next) return pass == 0 ? std::nullopt : std::optional(frame);
    frame = *next;
  }
  return frame;
}

}  // namespace micro
