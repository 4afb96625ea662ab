#include "brdf/colour.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "brdf/cie_tables.h"
#include "core/error.h"

namespace micro {
namespace {

double table_wavelength(std::size_t k) {
  return cie::kFirst + cie::kStep * static_cast<double>(k);
}

/// Tristimulus weight of each tabulated wavelength; those of Y add to one.
const std::vector<Vec3>& table_weights() {
  static const std::vector<Vec3> weights = [] {
    std::vector<Vec3> all;
    double y = 0;
    for (std::size_t k = 0; k < cie::kCount; ++k) {
      all.push_back(cie::kD65[k] * Vec3(cie::kX[k], cie::kY[k], cie::kZ[k]));
      y += all.back().y();
    }
    for (Vec3& weight : all)
      weight /= y;
    return all;
  }();
  return weights;
}

/// Linear sRGB to XYZ: the primaries scaled so that together they make the white.
const Eigen::Matrix3d& primaries() {
  static const Eigen::Matrix3d matrix = [] {
    const auto of_chromaticity = [](double x, double y) { return Vec3(x / y, 1, (1 - x - y) / y); };
    Eigen::Matrix3d columns;
    columns << of_chromaticity(0.64, 0.33), of_chromaticity(0.30, 0.60), of_chromaticity(0.15, 0.06);
    const Vec3 scale = columns.inverse() * white_point();
    return Eigen::Matrix3d(columns * scale.asDiagonal());
  }();
  return matrix;
}

double sigmoid_argument(const Vec3& c, double lambda) {
  const double t = (lambda - table_wavelength(0)) / (table_wavelength(cie::kCount - 1) - table_wavelength(0));
  return (c.x() * t + c.y()) * t + c.z();
}

double sigmoid(double x) {
  return 0.5 + x / (2 * std::sqrt(1 + x * x));
}

struct ColourAndJacobian {
  Vec3 rgb;
  Eigen::Matrix3d jacobian;
};

ColourAndJacobian colour_of(const Vec3& c) {
  static const Eigen::Matrix3d to_rgb = primaries().inverse();
  Vec3 xyz = Vec3::Zero();
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < cie::kCount; ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(cie::kCount - 1);
    const double x = sigmoid_argument(c, table_wavelength(k));
    const double slope = 1 / (2 * (1 + x * x) * std::sqrt(1 + x * x));
    xyz += sigmoid(x) * table_weights()[k];
    jacobian += slope * table_weights()[k] * Eigen::RowVector3d(t * t, t, 1);
  }
  return {to_rgb * xyz, to_rgb * jacobian};
}

}  // namespace

ColourWeights::ColourWeights(std::vector<double> lambda_um) : lambda_um_(std::move(lambda_um)) {
  if (lambda_um_.empty() || !std::ranges::is_sorted(lambda_um_, std::less_equal{}))
    throw InputError("a colour needs one or more wavelengths that ascend");
  weights_.assign(lambda_um_.size(), Vec3::Zero());
  for (std::size_t k = 0; k < cie::kCount; ++k) {
    const double lambda = table_wavelength(k);
    const auto above = std::ranges::upper_bound(lambda_um_, lambda);
    const auto next = static_cast<std::size_t>(above - lambda_um_.begin());
    if (next == 0 || next == lambda_um_.size()) {
      weights_[next == 0 ? 0 : next - 1] += table_weights()[k];
      continue;
    }
    const double t = (lambda - lambda_um_[next - 1]) / (lambda_um_[next] - lambda_um_[next - 1]);
    weights_[next - 1] += (1 - t) * table_weights()[k];
    weights_[next] += t * table_weights()[k];
  }
}

Vec3 ColourWeights::xyz(const std::vector<double>& reflectance) const {
  if (reflectance.size() != weights_.size())
    throw InputError("a colour needs a reflectance at each of its wavelengths");
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < weights_.size(); ++k)
    sum += reflectance[k] * weights_[k];
  return sum;
}

std::vector<double> visible_wavelengths(int n) {
  if (n < 1) throw InputError("a spectrum needs at least one wavelength");
  constexpr double kLow = 0.38, kHigh = 0.73;
  std::vector<double> lambda;
  for (int k = 0; k < n; ++k)
    lambda.push_back(kLow + (kHigh - kLow) * (k + 0.5) / n);
  return lambda;
}

Vec3 white_point() {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& weight : table_weights())
    sum += weight;
  return sum;
}

Vec3 linear_srgb(const Vec3& xyz) {
  static const Eigen::Matrix3d inverse = primaries().inverse();
  return inverse * xyz;
}

Vec3 xyz_of_linear_srgb(const Vec3& rgb) {
  return primaries() * rgb;
}

double srgb_encoded(double linear) {
  const double c = std::clamp(linear, 0., 1.);
  return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
}

double srgb_decoded(double encoded) {
  const double c = std::clamp(encoded, 0., 1.);
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

double SmoothReflectance::operator()(double lambda_um) const {
  return sigmoid(sigmoid_argument({c0, c1, c2}, lambda_um));
}

SmoothReflectance smooth_reflectance(const Vec3& linear_rgb) {
  if (!((linear_rgb.array() >= 0).all() && (linear_rgb.array() <= 1).all()))
    throw InputError("a reflectance's colour has components between 0 and 1");
  const double grey = std::clamp(2 * linear_rgb.mean() - 1, -0.99, 0.99);
  Vec3 c(0, 0, grey / std::sqrt(1 - grey * grey));
  double damping = 1e-6;
  ColourAndJacobian now = colour_of(c);
  constexpr double kEnough = 1e-10;
  for (int k = 0; k < 200 && (now.rgb - linear_rgb).norm() > kEnough; ++k) {
    const Eigen::Matrix3d normal = now.jacobian.transpose() * now.jacobian;
    const Eigen::Matrix3d damped = normal + damping * Eigen::Matrix3d(normal.diagonal().asDiagonal());
    const Vec3 tried = c + damped.ldlt().solve(now.jacobian.transpose() * (linear_rgb - now.rgb));
    const ColourAndJacobian then = colour_of(tried);
    if ((then.rgb - linear_rgb).squaredNorm() < (now.rgb - linear_rgb).squaredNorm()) {
      c = tried;
      now = then;
      damping /= 5;
    } else {
      damping *= 4;
    }
  }
  return {c.x(), c.y(), c.z(), (now.rgb - linear_rgb).cwiseAbs().maxCoeff()};
}

}  // namespace micro
