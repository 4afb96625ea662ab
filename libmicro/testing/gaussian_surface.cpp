#include "testing/gaussian_surface.h"

#include <cmath>

#include "core/random.h"

namespace micro::testing {
namespace {

/// Weights exp(−2x²/τ²) out to 3τ (1.5e-8), scaled so that Σw² = 1.
Eigen::VectorXd weights(double pitch, double tau) {
  const auto reach = static_cast<Eigen::Index>(std::ceil(3 * tau / pitch));
  Eigen::VectorXd w(2 * reach + 1);
  for (Eigen::Index k = 0; k < w.size(); ++k) {
    const double x = static_cast<double>(k - reach) * pitch / tau;
    w(k) = std::exp(-2 * x * x);
  }
  return w / w.norm();
}

}  // namespace

HeightField gaussian_surface(Eigen::Index rows, Eigen::Index cols, double dx, double dy,
                             const GaussianStatistics& statistics, std::uint64_t seed) {
  const Eigen::VectorXd wx = weights(dx, statistics.tau_x), wy = weights(dy, statistics.tau_y);
  Grid<double> noise(rows + wy.size() - 1, cols + wx.size() - 1);
  for (Eigen::Index k = 0; k < noise.size(); ++k)
    noise.data()[k] = random_normal(seed, 0, static_cast<std::uint64_t>(k))[0];
  Grid<double> across = Grid<double>::Zero(noise.rows(), cols), z = Grid<double>::Zero(rows, cols);
  for (Eigen::Index k = 0; k < wx.size(); ++k)
    across += wx(k) * noise.middleCols(k, cols);
  for (Eigen::Index k = 0; k < wy.size(); ++k)
    z += wy(k) * across.middleRows(k, rows);
  return make_height_field(z * statistics.sigma, dx, dy);
}

}  // namespace micro::testing
