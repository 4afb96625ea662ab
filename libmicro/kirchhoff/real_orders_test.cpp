// The pits of a real disc diffract: orders stand where the pitch of the tracks says.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <filesystem>

#include "height/level.h"
#include "io/scan.h"
#include "kirchhoff/spectral.h"

namespace micro {
namespace {

const std::filesystem::path kScan = std::filesystem::path(MICRO_SCANS_DIR) / "uncompressed.sur";

/// |∫ z w e^{−2πi f·x}|² at frequencies f = (k, l)·step in 1/µm, k ≥ 0, as a literal sum; w is a Hann window.
Grid<double> power_spectrum(const HeightField& surface, Eigen::Index half, double step) {
  const auto wave = [](Eigen::Index n, double pitch, double f) {
    const double hann = 0.5 - 0.5 * std::cos(2 * M_PI * static_cast<double>(n) * pitch);
    return hann * std::polar(1.0, -2 * M_PI * f * static_cast<double>(n));
  };
  using Matrix = Eigen::MatrixXcd;
  const Matrix along_x = Matrix::NullaryExpr(surface.cols(), half + 1, [&](auto i, auto k) {
    return wave(i, 1.0 / static_cast<double>(surface.cols()), static_cast<double>(k) * step * surface.dx);
  });
  const Matrix along_y = Matrix::NullaryExpr(2 * half + 1, surface.rows(), [&](auto l, auto j) {
    return wave(j, 1.0 / static_cast<double>(surface.rows()),
                static_cast<double>(l - half) * step * surface.dy);
  });
  return (along_y * (surface.z.matrix().cast<std::complex<double>>() * along_x)).cwiseAbs2().array();
}

/// The frequency of the tracks: the strongest between 0.4 and 1 per µm.
Vec2 track_frequency(const HeightField& surface) {
  constexpr Eigen::Index kHalf = 100;
  constexpr double kStep = 0.01;
  const Grid<double> power = power_spectrum(surface, kHalf, kStep);
  double strongest = 0;
  Vec2 found(0, 0);
  for (Eigen::Index l = 0; l <= 2 * kHalf; ++l)
    for (Eigen::Index k = 0; k <= kHalf; ++k) {
      const Vec2 f = Vec2(static_cast<double>(k), static_cast<double>(l - kHalf)) * kStep;
      if (f.norm() < 0.4 || f.norm() > 1 || power(l, k) <= strongest) continue;
      strongest = power(l, k);
      found = f;
    }
  return found;
}

/// Where D is largest within `radius` of `centre`.
Vec2 peak_near(const DiskTable& table, const Vec2& centre, double radius) {
  double highest = 0;
  Vec2 found(0, 0);
  for (Eigen::Index j = 0; j < table.grid.size; ++j)
    for (Eigen::Index i = 0; i < table.grid.size; ++i) {
      const Vec2 h(table.grid.coordinate(i), table.grid.coordinate(j));
      if ((h - centre).norm() > radius || table.density(j, i) <= highest) continue;
      highest = table.density(j, i);
      found = h;
    }
  return found;
}

TEST(RealGrating, OrdersStandWhereThePitchSays) {
  if (!std::filesystem::exists(kScan)) GTEST_SKIP() << "no " << kScan;
  const HeightField surface = level(read_scan(kScan, {}).surface, Level::Plane);
  const Vec2 f = track_frequency(surface);
  // Tracks of a compact disc are 1.5 to 1.7 µm apart.
  EXPECT_NEAR(1 / f.norm(), 1.6, 0.1);
  const double side = 10;  // µm
  for (const double lambda_q : {0.3, 0.405, 0.555, 0.65}) {
    SCOPED_TRACE(lambda_q);
    const Vec2 first = lambda_q / 2 * f;  // q_⊥ = 2π f
    const double cell = lambda_q / (2 * side);
    const DiskTable table = spectral_table(surface, {257, 1.6 * first.norm()}, lambda_q, 1e-3).table;
    for (const double sign : {-1.0, 1.0})
      EXPECT_LE((peak_near(table, sign * first, first.norm() / 2) - sign * first).norm(), cell);
  }
}

}  // namespace
}  // namespace micro
