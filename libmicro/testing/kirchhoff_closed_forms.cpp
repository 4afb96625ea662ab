#include "testing/kirchhoff_closed_forms.h"

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>

namespace micro::testing {
namespace {

using Complex = std::complex<double>;

double sinc(double x) {
  return x == 0 ? 1 : std::sin(x) / x;
}

/// ∫₀^L e^{−ikx} dx.
Complex wave_integral(double k, double length) {
  return length * sinc(k * length / 2) * std::polar(1.0, -k * length / 2);
}

}  // namespace

Complex plate_field(const Rectangle& patch, const Vec2& slope, const Vec3& q) {
  return (q.z() - q.x() * slope.x() - q.y() * slope.y()) *
         wave_integral(q.x() + q.z() * slope.x(), patch.length_x) *
         wave_integral(q.y() + q.z() * slope.y(), patch.length_y);
}

Complex sinusoid_field(const Rectangle& patch, double amplitude, double wave_number, double phase,
                       const Vec3& q) {
  const double depth = q.z() * amplitude;
  // J_n falls faster than exponentially once n exceeds its argument.
  const int orders = static_cast<int>(std::ceil(std::abs(depth) + 12 * std::cbrt(std::abs(depth)) + 25));
  Complex integral = 0;
  for (int n = -orders; n <= orders; ++n) {
    const int turn = ((n % 4) + 4) % 4;
    const Complex minus_i_to_n = turn == 0 ? 1 : turn == 1 ? Complex(0, -1) : turn == 2 ? -1 : Complex(0, 1);
    integral += minus_i_to_n * boost::math::cyl_bessel_j(n, depth) * std::polar(1.0, n * phase) *
                wave_integral(q.x() - n * wave_number, patch.length_x);
  }
  const auto wave = [&](double x) {
    return std::polar(1.0, -q.x() * x - depth * std::cos(wave_number * x + phase));
  };
  const Complex boundary = wave(patch.length_x) - wave(0);
  const Complex along_x = (q.z() + q.x() * q.x() / q.z()) * integral - Complex(0, q.x() / q.z()) * boundary;
  return along_x * wave_integral(q.y(), patch.length_y);
}

Complex profile_field(const Rectangle& patch, std::span<const double> heights, const Vec3& q) {
  const double pitch = patch.length_x / static_cast<double>(heights.size() - 1);
  Complex sum = 0;
  for (std::size_t k = 0; k + 1 < heights.size(); ++k) {
    const double slope = (heights[k + 1] - heights[k]) / pitch;
    sum += (q.z() - q.x() * slope) * wave_integral(q.x() + q.z() * slope, pitch) *
           std::polar(1.0, -q.x() * pitch * static_cast<double>(k) - q.z() * heights[k]);
  }
  return sum * wave_integral(q.y(), patch.length_y);
}

}  // namespace micro::testing
