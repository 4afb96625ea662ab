#include "fit/identify.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <limits>
#include <numbers>
#include <sstream>

namespace micro {
namespace {

Vector5 as_vector(const EllipsoidParameters& p) {
  return (Vector5() << p.alpha_x, p.alpha_y, p.theta_x, p.theta_y, p.theta_z).finished();
}

/// "0.71 t_1 − 0.7 log L_11": the parts that matter.
std::string in_words(Vector5 direction) {
  constexpr std::array kNames = {"t_1", "t_2", "log L_11", "L_21", "log L_22"};
  constexpr double kMatters = 0.1;
  for (int k = 0; k < 5; ++k)
    if (std::abs(direction[k]) > kMatters) {
      if (direction[k] < 0) direction = -direction;
      break;
    }
  std::ostringstream text;
  text << std::setprecision(2);
  for (int k = 0; k < 5; ++k)
    if (std::abs(direction[k]) > kMatters)
      text << (text.tellp() == 0  ? ""
               : direction[k] < 0 ? " - "
                                  : " + ")
           << std::abs(direction[k]) << " " << kNames[static_cast<std::size_t>(k)];
  return text.str();
}

/// ∂(canonical parameters)/∂δ by central differences; angles by the shorter way round.
Matrix5 jacobian_of(const SlopeFrame& frame) {
  constexpr double kStep = 1e-6;
  Matrix5 jacobian;
  for (int k = 0; k < 5; ++k) {
    const Vector5 step = kStep * Vector5::Unit(k);
    Vector5 change = as_vector(canonical_parameters(moved(frame, step))) -
                     as_vector(canonical_parameters(moved(frame, -step)));
    change[4] = std::remainder(change[4], std::numbers::pi);
    jacobian.col(k) = change / (2 * kStep);
  }
  return jacobian;
}

}  // namespace

Identified identify(const Matrix5& gram) {
  constexpr double kFree = 1e-9;
  Identified result;
  const Eigen::SelfAdjointEigenSolver<Matrix5> solver(gram);
  const Vector5& values = solver.eigenvalues();
  for (int k = 0; k < 5; ++k)
    if (!(values[k] > kFree * values[4]))
      result.free += (result.free.empty() ? "" : "; ") + in_words(solver.eigenvectors().col(k));
  result.inverse =
      solver.eigenvectors() * values.cwiseInverse().asDiagonal() * solver.eigenvectors().transpose();
  return result;
}

std::string barely_known(const Matrix5& step_covariance) {
  constexpr double kLinear = 0.1;
  const Eigen::SelfAdjointEigenSolver<Matrix5> solver(step_covariance);
  const double error = std::sqrt(std::max(0., solver.eigenvalues()[4]));
  if (error <= kLinear) return "";
  std::ostringstream text;
  text << in_words(solver.eigenvectors().col(4)) << " only to " << std::setprecision(2) << error
       << " widths: errors hold to first order";
  return text.str();
}

Canonical canonical_with_covariance(const SlopeFrame& frame, const Matrix5& covariance) {
  constexpr double kLeast = 1e-6, kErrors = 3;
  Canonical result;
  result.parameters = canonical_parameters(frame);
  EllipsoidParameters& p = result.parameters;
  // Away from roundness in slope space are δ_11 − δ_22 and δ_21; the larger one's standard error, or better,
  // that of the worst combination of the two.
  Eigen::Matrix<double, 2, 5> away = Eigen::Matrix<double, 2, 5>::Zero();
  away(0, 2) = 1;
  away(0, 4) = -1;
  away(1, 3) = 1;
  const Eigen::Matrix2d spread = away * covariance * away.transpose();
  const double error = std::sqrt(std::max(
      0., Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread, Eigen::EigenvaluesOnly).eigenvalues()[1]));
  result.round = std::log(p.alpha_x / p.alpha_y) < std::max(kLeast, kErrors * error);
  Matrix5 jacobian = jacobian_of(frame);
  if (result.round) {
    const double alpha = std::sqrt(p.alpha_x * p.alpha_y);
    const SlopeFrame round = slope_frame({alpha, alpha, p.theta_x, p.theta_y, p.theta_z});
    p = canonical_parameters(round);
    // Both widths are the mean one; which is the larger is chance.
    const Eigen::Matrix<double, 1, 5> mean = (jacobian.row(0) + jacobian.row(1)) / 2;
    jacobian.row(0) = jacobian.row(1) = mean;
  }
  result.covariance = jacobian * covariance * jacobian.transpose();
  if (result.round) {
    result.covariance.row(4).setConstant(std::numeric_limits<double>::quiet_NaN());
    result.covariance.col(4).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return result;
}

}  // namespace micro
