#include "distribution/beckmann.h"

#include <algorithm>
#include <numbers>

#include "core/error.h"

namespace micro {
namespace {

constexpr double kSqrtPi = 1 / std::numbers::inv_sqrtpi;
constexpr double kFar = 7;  // erfc(7) < 1e-22: no slope lies beyond

/// 1 − √π·z·e^{z²}erfc(z) for z ≥ 0, which falls as 1/(2z²): from there on by its asymptotic series.
double mills_deficit(double z) {
  if (z < kFar) return 1 - kSqrtPi * z * std::exp(z * z) * std::erfc(z);
  const double x = 1 / (2 * z * z);
  double term = x, sum = 0;
  for (int n = 1; n <= 15; ++n) {
    sum += term;
    term *= -(2 * n + 1) * x;
  }
  return sum;
}

/// √π·e^{z²}erfc(z), z ≥ 0.
double scaled_tail(double z) {
  return z < kFar ? kSqrtPi * std::exp(z * z) * std::erfc(z) : (1 - mills_deficit(z)) / z;
}

/// The x in [low, high] where a function that rises from below 0 to above crosses 0: Newton's steps, halved
/// intervals where they leave the bracket. `f` gives value and derivative.
template <typename F>
double root(F&& f, double low, double high, double x) {
  for (int k = 0; k < 100; ++k) {
    const auto [value, slope] = f(x);
    (value < 0 ? low : high) = x;
    const double newton = x - value / slope;
    const double next = newton > low && newton < high ? newton : (low + high) / 2;
    if (std::abs(next - x) <= 1e-15 * std::abs(x) || next == x) return next;
    x = next;
  }
  return x;
}

struct ValueAndSlope {
  double value, slope;
};

/// Inverse of the distribution function ½erfc(−y), y's density e^{−y²}/√π.
double gaussian_quantile(double xi) {
  const double tail = std::min(xi, 1 - xi);  // the lower half: small probabilities stay exact
  const double y = root(
      [&](double x) -> ValueAndSlope {
        return {std::erfc(-x) / 2 - tail, std::exp(-x * x) * std::numbers::inv_sqrtpi};
      },
      -kFar, 0, -0.5);
  return xi < 0.5 ? y : -y;
}

/// x below c with density ∝ (c − x)e^{−x²}: the slope along a direction of cotangent c that sees it.
double visible_slope(double c, double xi) {
  if (c >= 0) {
    const auto mass = [&](double x) {
      return c * std::erfc(-x) / 2 + std::exp(-x * x) * std::numbers::inv_sqrtpi / 2;
    };
    const double high = std::min(c, kFar), target = xi * mass(high), scale = 1 / mass(high);
    return root(
        [&](double x) -> ValueAndSlope {
          return {(mass(x) - target) * scale, scale * (c - x) * std::exp(-x * x) * std::numbers::inv_sqrtpi};
        },
        -kFar, high, std::min(high, 0.) - 0.3);
  }
  // Only the far flank is seen. Beyond x = c − w lies ½e^{−w²−2kw}·(deficit(w + k) + w·√π·erfcx(w + k)), k =
  // −c, in units of e^{−c²}/√π.
  const double k = -c, whole = mills_deficit(k), high = std::min(kFar, 40 / k);
  const double w = root(
      [&](double x) -> ValueAndSlope {
        const double fall = std::exp(-x * (x + 2 * k));
        const double beyond = fall * (mills_deficit(x + k) + x * scaled_tail(x + k));
        return {1 - xi - beyond / whole, 2 * x * fall / whole};
      },
      0, high, std::min(0.5, 1 / k));
  return c - w;
}

}  // namespace

double GaussianShape::density(double vv, double z) {
  constexpr double kUnderflow = 800;
  const double exponent = vv / (z * z);
  if (exponent > kUnderflow) return 0;  // on the horizon too
  return std::numbers::inv_pi * std::exp(-exponent) / (z * z * z * z);
}

double GaussianShape::visible_area(const Vec3& u) {
  const double across = std::hypot(u.x(), u.y());
  if (across == 0) return std::max(0., u.z());
  const double c = u.z() / across, z = std::abs(c);
  const double flank = across / 2 * std::exp(-z * z) * std::numbers::inv_sqrtpi * mills_deficit(z);
  return c > 0 ? u.z() + flank : flank;
}

Vec2 GaussianShape::sample(const Vec2& xi) {
  const double r = std::sqrt(-std::log1p(-std::min(xi.x(), 1 - 0x1p-53)));
  const double phi = 2 * std::numbers::pi * xi.y();
  return {r * std::cos(phi), r * std::sin(phi)};
}

Vec2 GaussianShape::sample_visible(const Vec3& u, const Vec2& xi) {
  const double across = std::hypot(u.x(), u.y());
  const double beside = gaussian_quantile(xi.y());
  // Straight from above all slopes weigh the same, straight from below none is seen: then the steepest.
  constexpr double kStraight = 1e150;
  const double c = std::clamp(u.z() / across, -kStraight, kStraight);
  const double along = visible_slope(c, xi.x());
  const Vec2 e = across > 0 ? Vec2(u.x() / across, u.y() / across) : Vec2(1, 0);
  return {along * e.x() - beside * e.y(), along * e.y() + beside * e.x()};
}

Beckmann gaussian_surface_normals(const GaussianSurfaceStatistics& surface) {
  const auto& [sigma_h, tau_x, tau_y, filter] = surface;
  if (!(sigma_h > 0 && tau_x > 0 && tau_y > 0 && filter >= 0))
    throw InputError("a Gaussian surface needs positive heights and correlation lengths");
  const double x2 = tau_x * tau_x + 4 * filter * filter, y2 = tau_y * tau_y + 4 * filter * filter;
  const double sigma = sigma_h * std::sqrt(tau_x * tau_y / std::sqrt(x2 * y2));
  return Beckmann({{0, 0}, 2 * sigma / std::sqrt(x2), 0, 2 * sigma / std::sqrt(y2)});
}

}  // namespace micro
