#include "testing/cosine_surface.h"

#include <cmath>
#include <complex>
#include <numbers>

#include "core/random.h"

namespace micro::testing {

HeightField make_gaussian_surface(const GaussianSurface& s, std::uint64_t seed) {
  Grid<double> z = Grid<double>::Zero(s.rows, s.cols);
  for (int wave = 0; wave < s.waves; ++wave) {
    // The spectrum of exp(−x²/τ²) is a Gaussian of standard deviation √2/τ.
    const auto normal = random_normal(seed, 1, static_cast<std::uint64_t>(wave));
    const double kx = normal[0] * std::numbers::sqrt2 / s.tau_x,
                 ky = normal[1] * std::numbers::sqrt2 / s.tau_y;
    const double phase = 2 * std::numbers::pi * random_uniform(seed, 2, static_cast<std::uint64_t>(wave))[0];
    const std::complex<double> step = std::polar(1.0, kx * s.dx);
    for (Eigen::Index j = 0; j < s.rows; ++j) {
      std::complex<double> e = std::polar(1.0, ky * s.dy * static_cast<double>(j) + phase);
      for (Eigen::Index i = 0; i < s.cols; ++i, e *= step)
        z(j, i) += e.real();
    }
  }
  return make_height_field(z * (s.rms * std::sqrt(2.0 / s.waves)), s.dx, s.dy);
}

HeightField with_missing(HeightField surface, double fraction, std::uint64_t seed) {
  for (Eigen::Index n = 0; n < surface.z.size(); ++n)
    if (random_uniform(seed, 3, static_cast<std::uint64_t>(n))[0] < fraction)
      surface.z(n / surface.cols(), n % surface.cols()) = kMissing;
  return surface;
}

}  // namespace micro::testing
