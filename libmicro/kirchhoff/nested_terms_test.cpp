#include "kirchhoff/nested_terms.h"

#include <gtest/gtest.h>

#include <complex>

#include "testing/cosine_surface.h"

namespace micro {
namespace {

/// Root mean square error of ψ from the first terms that q_z takes, over the heights as they occur.
double rms_error(const HeightHistogram& heights, const NestedTerms& terms, const WaveRange& q, int entry,
                 int entries) {
  const double qz = q.low + (q.high - q.low) * entry / (entries - 1);
  const int needed = terms.needed(qz);
  const auto bins = static_cast<int>(heights.mass.size());
  const Eigen::ArrayXXcd c = terms.coefficients(entries, 0, needed);
  const HeightBasis::Functions f = terms.functions(2 * bins + 1, 0, needed);
  double sum = 0;
  for (int b = 0; b < bins; ++b) {
    const double h = heights.low + (heights.high - heights.low) * (b + 0.5) / bins;
    const std::complex<double> want = (std::polar(1.0, -qz * h) - 1.0) / qz;
    std::complex<double> got = 0;
    for (int k = 0; k < needed; ++k)
      got += c(entry, k) * f.value(2 * b + 1, k);
    sum += heights.mass[b] * std::norm(got - want);
  }
  return std::sqrt(sum);
}

TEST(NestedTerms, FirstTermsServeSmallWaveNumbers) {
  const HeightHistogram heights = height_histogram(testing::make_gaussian_surface({.rms = 0.4}, 1));
  const WaveRange q = {0, 30};
  for (const double tolerance : {1e-3, 1e-5}) {
    const HeightBasis basis(heights, 0, q, tolerance);
    const NestedTerms terms(basis, q, tolerance);
    EXPECT_LE(terms.needed(5), terms.terms() / 2);
    // Orders of no use to one q_z are left out of the basis: nesting costs few more than all together.
    EXPECT_LE(terms.terms(), basis.terms());
    int before = 0;
    constexpr int kEntries = 61;
    for (int entry = 1; entry < kEntries; entry += 6) {
      const double qz = q.high * entry / (kEntries - 1);
      EXPECT_GE(terms.needed(qz), before);
      before = terms.needed(qz);
      // Mean squares over q_z are bounded; a single q_z may exceed them.
      EXPECT_LE(rms_error(heights, terms, q, entry, kEntries), 6 * tolerance) << qz;
    }
    EXPECT_EQ(terms.needed(30), terms.terms());
  }
}

TEST(NestedTerms, ChebyshevSeriesNestByThemselves) {
  HeightHistogram heights{-30, 30, Eigen::ArrayXd::Constant(512, 1.0 / 512)};
  const WaveRange q = {0, 20};
  const HeightBasis basis(heights, 0, q, 1e-3);
  ASSERT_FALSE(basis.orthonormal());
  const NestedTerms terms(basis, q, 1e-3);
  EXPECT_LE(terms.needed(5), 0.4 * terms.terms());
  for (const int entry : {5, 20, 40})
    EXPECT_LE(rms_error(heights, terms, q, entry, 41), 4e-3);
}

TEST(NestedTerms, APlaneHasNone) {
  const HeightHistogram heights{0, 0, Eigen::ArrayXd::Constant(1, 1)};
  const HeightBasis basis(heights, 0, {0, 20}, 1e-3);
  const NestedTerms terms(basis, {0, 20}, 1e-3);
  EXPECT_EQ(terms.terms(), 0);
  EXPECT_EQ(terms.needed(7), 0);
}

}  // namespace
}  // namespace micro
