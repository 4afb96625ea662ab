#include "fit/identify.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <limits>
#include <numbers>
#include <sstream>
#include <vector>

#include "distribution/equal_axes.h"

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

/// ∂f/∂δ by central differences, f of Rows numbers of a frame.
template <int Rows, typename F>
Eigen::Matrix<double, Rows, 5> derivative(const SlopeFrame& frame, F&& change_between) {
  constexpr double kStep = 1e-6;
  Eigen::Matrix<double, Rows, 5> jacobian;
  for (int k = 0; k < 5; ++k) {
    const Vector5 step = kStep * Vector5::Unit(k);
    jacobian.col(k) = change_between(moved(frame, -step), moved(frame, step)) / (2 * kStep);
  }
  return jacobian;
}

/// The same ellipsoid's parameters nearest to `p`: beyond θ_z = ±π/2 two axes point the other way, and both
/// other angles change their sign.
Vector5 nearest(Vector5 parameters, const Vector5& p) {
  const double turn = parameters[4] - p[4];
  if (std::abs(turn) <= std::numbers::pi / 2) return parameters;
  parameters[2] = -parameters[2];
  parameters[3] = -parameters[3];
  parameters[4] -= std::copysign(std::numbers::pi, turn);
  return parameters;
}

/// Of the canonical parameters.
Matrix5 jacobian_of(const SlopeFrame& frame, EqualAxes equal) {
  const Vector5 here = as_vector(canonical_parameters(frame, equal));
  return derivative<5>(frame, [&](const SlopeFrame& from, const SlopeFrame& to) -> Vector5 {
    return nearest(as_vector(canonical_parameters(to, equal)), here) -
           nearest(as_vector(canonical_parameters(from, equal)), here);
  });
}

/// Of how far two axes a and b (unit vectors) are from equally long: of ln(|Fa|/|Fb|), and of the cosine
/// between Fa and Fb. To first order the logarithm of the lengths' ratio is the length of this vector.
Eigen::Matrix<double, 2, 5> inequality_of(const SlopeFrame& frame, const Vec3& a, const Vec3& b) {
  const auto inequality = [&](const SlopeFrame& of) -> Vec2 {
    const Vec3 fa = axes_matrix(of) * a, fb = axes_matrix(of) * b;
    return {std::log(fa.norm() / fb.norm()), fa.dot(fb) / (fa.norm() * fb.norm())};
  };
  return derivative<2>(frame, [&](const SlopeFrame& from, const SlopeFrame& to) -> Vec2 {
    return inequality(to) - inequality(from);
  });
}

/// Which axes are equally long within three standard errors: of the worst combination of what tells them
/// apart. Errors beyond the first order, of a needle whose length is unknown, call nothing equal. Where not
/// all three are and either pair might be, it is the pair nearer to it.
EqualAxes equal_axes(const SlopeFrame& frame, const Matrix5& covariance) {
  constexpr double kLeast = 1e-6, kErrors = 3, kFarthest = 0.5;
  const PrincipalAxes axes = principal_axes(frame);
  const auto away = [&](int a, int b) {
    const auto jacobian = inequality_of(frame, axes.direction.col(a), axes.direction.col(b));
    const Eigen::Matrix2d spread = jacobian * covariance * jacobian.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread, Eigen::EigenvaluesOnly);
    const double error = std::sqrt(std::max(0., solver.eigenvalues()[1]));
    return std::log(axes.length[a] / axes.length[b]) / std::clamp(kErrors * error, kLeast, kFarthest);
  };
  if (away(0, 2) < 1) return EqualAxes::All;
  const double longest = away(0, 1), shortest = away(1, 2);
  if (std::min(longest, shortest) >= 1) return EqualAxes::None;
  return longest < shortest ? EqualAxes::TwoLongest : EqualAxes::TwoShortest;
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

BarelyKnown barely_known(const Matrix5& step_covariance) {
  constexpr double kLinear = 0.1;
  const Eigen::SelfAdjointEigenSolver<Matrix5> solver(step_covariance);
  const double error = std::sqrt(std::max(0., solver.eigenvalues()[4]));
  if (error <= kLinear) return {error, ""};
  std::ostringstream text;
  text << in_words(solver.eigenvectors().col(4)) << " only to " << std::setprecision(2) << error
       << " widths: errors hold to first order";
  return {error, text.str()};
}

Canonical canonical_with_covariance(const SlopeFrame& frame, const Matrix5& covariance) {
  const EqualAxes equal = equal_axes(frame, covariance);
  Canonical result;
  result.parameters = canonical_parameters(frame, equal);
  const EllipsoidParameters& p = result.parameters;
  Matrix5 jacobian = jacobian_of(frame, equal);
  std::vector<int> lost;  // rows of angles
  if (equal != EqualAxes::None) {
    const bool sphere = equal == EqualAxes::All;
    // A width that equals the third axis is known as well as the ratio of the two.
    const Eigen::Matrix3d r = rotation(p);
    if (p.alpha_x == 1) jacobian.row(0) = inequality_of(frame, r.row(0), r.row(2)).row(0);
    if (p.alpha_y == 1) jacobian.row(1) = inequality_of(frame, r.row(1), r.row(2)).row(0);
    if (sphere) {
      result.meaningless = "theta_x, theta_y and theta_z: the ellipsoid is a sphere";
      lost = {2, 3, 4};
    } else if (p.alpha_x == p.alpha_y) {
      result.meaningless = "theta_z: the lobe is round";
      lost = {4};
    } else if (p.alpha_y == 1) {
      result.meaningless = "theta_x: alpha_y equals the third axis, and turning these two changes nothing";
      lost = {2};
    } else {
      result.meaningless = "theta_y: alpha_x equals the third axis, and turning these two changes nothing";
      lost = {3};
    }
  }
  result.covariance = jacobian * covariance * jacobian.transpose();
  for (const int row : lost) {
    result.covariance.row(row).setConstant(std::numeric_limits<double>::quiet_NaN());
    result.covariance.col(row).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return result;
}

}  // namespace micro
