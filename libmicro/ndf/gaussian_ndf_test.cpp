#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <vector>

#include "height/gaussian_surface.h"
#include "ndf/normal_counts.h"

// Filtered NDF of Gaussian surfaces against its closed form: a surface with C = σ_h² exp(−x²/τ_x² − y²/τ_y²),
// filtered with a Gaussian of standard deviation s, has normal slopes of variance per axis
//   v_x = 2σ_h² τ_x τ_y/(t_x³ t_y),  t² = τ² + 4s² for each axis (C convolved with a Gaussian of variance
//   2s²),
// which for τ_x = τ_y is 2σ_h²τ²/(τ² + 4s²)², the Beckmann distribution of α² = 2v.
namespace micro {
namespace {

constexpr SyntheticGrid kGrid{.rows = 220, .cols = 240, .dx = 0.2, .dy = 0.2};
constexpr double kSigma = 0.5;
constexpr Eigen::Index kBorder = 18;  // 7σ/pitch: windows that the border does not cut
constexpr int kScans = 60;

Vec2 filtered_variance(const GaussianField& field) {
  const double tx = std::hypot(field.tau_x, 2 * kSigma), ty = std::hypot(field.tau_y, 2 * kSigma);
  const double scale = 2 * field.rms * field.rms * field.tau_x * field.tau_y / (tx * ty);
  return {scale / (tx * tx), scale / (ty * ty)};
}

/// Slopes of one scan's complete windows.
SlopeField interior_slopes(const GaussianField& field, std::uint64_t seed) {
  const SlopeField all = local_planes(gaussian_surface(kGrid, field, seed), kSigma);
  const auto inside = [](const Grid<double>& slopes) {
    return Grid<double>(
        slopes.block(kBorder, kBorder, slopes.rows() - 2 * kBorder, slopes.cols() - 2 * kBorder));
  };
  return {inside(all.zx), inside(all.zy), 0, 0};
}

/// P value of Σt² over tests of means whose scans are independent; each Student t is mapped to a normal
/// number first.
class MeanTests {
 public:
  void add(const std::vector<double>& samples, double expected) {
    const double n = static_cast<double>(samples.size());
    double mean = 0, square = 0;
    for (const double x : samples)
      mean += x / n;
    for (const double x : samples)
      square += (x - mean) * (x - mean) / (n - 1);
    const double t = (mean - expected) / std::sqrt(square / n);
    const boost::math::students_t student(n - 1);
    p_.push_back(2 * cdf(complement(student, std::abs(t))));
  }
  /// Smallest p, corrected for the number of tests.
  double corrected() const {
    double least = 1;
    for (const double p : p_)
      least = p < least ? p : std::isnan(p) ? 0 : least;
    return least * static_cast<double>(p_.size());
  }

 private:
  std::vector<double> p_;
};

constexpr double kSignificance = 1e-4;

void expect_beckmann(const GaussianField& field) {
  const Vec2 variance = filtered_variance(field);
  // Bins of equal probability: a product of quantiles in each normalised slope.
  constexpr int kBins = 6;
  const boost::math::normal normal;
  std::vector<double> edges;
  for (int k = 1; k < kBins; ++k)
    edges.push_back(quantile(normal, static_cast<double>(k) / kBins));
  std::vector<double> vx, vy;
  std::vector<std::vector<double>> mass(kBins * kBins);
  for (int scan = 0; scan < kScans; ++scan) {
    const SlopeField slopes = interior_slopes(field, static_cast<std::uint64_t>(100 + scan));
    vx.push_back(slopes.zx.square().mean());
    vy.push_back(slopes.zy.square().mean());
    std::vector<double> counts(kBins * kBins, 0.);
    const auto bin = [&](double u) {
      return static_cast<int>(std::upper_bound(edges.begin(), edges.end(), u) - edges.begin());
    };
    for (Eigen::Index k = 0; k < slopes.zx.size(); ++k)
      counts[static_cast<std::size_t>(bin(slopes.zx.data()[k] / std::sqrt(variance.x())) * kBins +
                                      bin(slopes.zy.data()[k] / std::sqrt(variance.y())))] +=
          1. / static_cast<double>(slopes.zx.size());
    for (std::size_t b = 0; b < counts.size(); ++b)
      mass[b].push_back(counts[b]);
  }
  MeanTests tests;
  tests.add(vx, variance.x());
  tests.add(vy, variance.y());
  for (const auto& samples : mass)
    tests.add(samples, 1. / (kBins * kBins));
  EXPECT_GT(tests.corrected(), kSignificance);
}

TEST(GaussianNdf, FilteredSlopesAreBeckmannIsotropic) {
  expect_beckmann({.rms = 0.3, .tau_x = 1.5, .tau_y = 1.5});
}

TEST(GaussianNdf, FilteredSlopesAreBeckmannBrushed) {
  expect_beckmann({.rms = 0.2, .tau_x = 4, .tau_y = 1});
}

// The table itself: mass in rings of |m_xy| against Beckmann's, P(tanθ < t) = 1 − exp(−t²/α²).
TEST(GaussianNdf, TheTableHoldsBeckmannsMass) {
  const GaussianField field{.rms = 0.3, .tau_x = 1.5, .tau_y = 1.5};
  const double alpha2 = 2 * filtered_variance(field).x();
  constexpr double kRings[] = {0.05, 0.1, 0.15, 0.2, 0.3};  // |m_xy|, in the middle between rings of nodes
  std::vector<std::vector<double>> mass(std::size(kRings));
  for (int scan = 0; scan < kScans; ++scan) {
    const DiskTable table =
        density(filtered_counts(interior_slopes(field, static_cast<std::uint64_t>(500 + scan)), {1025, 1}));
    for (std::size_t r = 0; r < std::size(kRings); ++r) {
      double inside = 0;
      for (Eigen::Index j = 0; j < 1025; ++j)
        for (Eigen::Index i = 0; i < 1025; ++i)
          if (std::hypot(table.grid.coordinate(i), table.grid.coordinate(j)) < kRings[r])
            inside += table.density(j, i);
      mass[r].push_back(inside * table.grid.spacing() * table.grid.spacing());
    }
  }
  MeanTests tests;
  for (std::size_t r = 0; r < std::size(kRings); ++r) {
    const double tan2 = kRings[r] * kRings[r] / (1 - kRings[r] * kRings[r]);
    tests.add(mass[r], 1 - std::exp(-tan2 / alpha2));
  }
  EXPECT_GT(tests.corrected(), kSignificance);
}

}  // namespace
}  // namespace micro
