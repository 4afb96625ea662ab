#include <gtest/gtest.h>

#include <boost/math/quadrature/exp_sinh.hpp>
#include <boost/math/special_functions/erf.hpp>
#include <numbers>

#include "core/error.h"
#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "testing/chi_square.h"
#include "testing/ellipsoid_formula.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;

Vec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// A uniform direction of the hemisphere.
Vec3 random_direction(std::uint64_t seed, std::uint64_t k) {
  const auto [a, b] = random_uniform(seed, 9, k);
  return {std::sqrt(1 - a * a) * std::cos(2 * kPi * b), std::sqrt(1 - a * a) * std::sin(2 * kPi * b), a};
}

EllipsoidParameters mild_parameters(std::uint64_t k) {
  const auto [a, b] = random_uniform(1, 0, k);
  const auto [x, y] = random_uniform(1, 1, k);
  return {0.05 + a, 0.05 + b, 1.2 * (x - 0.5), 1.2 * (y - 0.5), kPi * random_uniform(1, 2, k)[0]};
}

/// Lobes that the sampling is tried on, skewed ones that lean far out included.
const std::vector<SlopeFrame>& frames() {
  static const std::vector<SlopeFrame> all = {
      slope_frame({0.3, 0.3, 0, 0, 0}),       slope_frame({0.5, 0.05, 0, 0, 0.4}),
      slope_frame({0.4, 0.1, 0.5, -0.3, 1}),  slope_frame({0.2, 0.1, 1.3, 0.2, -0.7}),
      slope_frame({3, 0.5, 0.2, 0.4, 0.1}),   slope_frame({0.01, 0.01, -0.8, 0, 0}),
      slope_frame({1e-4, 1e-3, 0.1, 0.1, 2}), slope_frame({100, 0.01, 0.1, 0.1, 2})};
  return all;
}

/// Density of v, in the lobe's own round coordinates, from a density in 1/sr: dω = m_z³ det L d²v.
template <typename Pdf>
auto in_round_slopes(const SlopeFrame& frame, Pdf pdf) {
  return [&frame, pdf](const Vec2& v) {
    const Vec3 m = normal_of(frame.unwhiten(v));
    return pdf(m) * m.z() * m.z() * m.z() * frame.l11 * frame.l22;
  };
}

template <typename Lobe>
class SlopeLobes : public ::testing::Test {};
using Shapes = ::testing::Types<Ellipsoid, Beckmann>;
TYPED_TEST_SUITE(SlopeLobes, Shapes);

TYPED_TEST(SlopeLobes, PdfsIntegrateToOne) {
  constexpr double kMidpoint = 1e-3;  // the kink where visible normals end
  const testing::PlaneBins bins{1, 1};
  for (const SlopeFrame& frame : frames()) {
    const TypeParam lobe(frame);
    const auto plain = in_round_slopes(frame, [&](const Vec3& m) { return lobe.pdf(m); });
    EXPECT_NEAR(bins.integrate(plain, 400)[0], 1, kMidpoint);
    for (const double theta : {0., 0.6, 1.4}) {
      const Vec3 u = direction(theta, 2.2);
      if (!(lobe.visible_area(u) > 1e-3 * frame.l11)) continue;  // a far tail falls between the midpoints
      const auto visible = in_round_slopes(frame, [&](const Vec3& m) { return lobe.pdf_visible(u, m); });
      EXPECT_NEAR(bins.integrate(visible, 400)[0], 1, 5 * kMidpoint) << frame.centre << " " << theta;
    }
  }
}

TYPED_TEST(SlopeLobes, SamplesFollowTheirDensities) {
  constexpr int kSamples = 40000;
  constexpr double kSmallestP = 1e-5;  // some 50 tests
  const testing::PlaneBins bins{8, 12};
  const auto expect_sampled = [&](const SlopeFrame& frame, auto&& pdf, auto&& sample, std::uint32_t stream) {
    std::vector<double> expected = bins.integrate(in_round_slopes(frame, pdf), 24);
    for (double& e : expected)
      e *= kSamples;
    std::vector<double> counts(bins.size(), 0.);
    for (std::uint64_t k = 0; k < kSamples; ++k) {
      const auto [a, b] = random_uniform(7, stream, k);
      const Vec3 m = sample(Vec2(a, b));
      ASSERT_NEAR(m.norm(), 1, 1e-12);
      ASSERT_GE(m.z(), 0);
      counts[bins.bin_of(frame.whiten(slope_of(m)))] += 1;
    }
    EXPECT_GT(testing::chi_square_p(counts, expected), kSmallestP) << frame.centre.transpose();
  };
  std::uint32_t stream = 0;
  for (const SlopeFrame& frame : frames()) {
    const TypeParam lobe(frame);
    expect_sampled(
        frame, [&](const Vec3& m) { return lobe.pdf(m); }, [&](const Vec2& xi) { return lobe.sample(xi); },
        stream++);
    for (const double theta : {0.5, 1.5}) {
      const Vec3 u = direction(theta, 3.5);
      if (!(lobe.visible_area(u) > 1e-2 * frame.l11)) continue;  // far tails have their own tests
      expect_sampled(
          frame, [&](const Vec3& m) { return lobe.pdf_visible(u, m); },
          [&](const Vec2& xi) { return lobe.sample_visible(u, xi); }, stream++);
    }
  }
}

// ∫D⟨m, u⟩dω by quadrature; G1 makes it cos θ unless it is clamped.
TYPED_TEST(SlopeLobes, VisibleAreaIsItsIntegral) {
  constexpr double kMidpoint = 1e-3;
  const testing::PlaneBins bins{1, 1};
  for (const SlopeFrame& frame : frames()) {
    const TypeParam lobe(frame);
    for (const double theta : {0., 0.9, 1.5})
      for (const double phi : {0.3, 3.4}) {
        const Vec3 u = direction(theta, phi);
        const auto seen =
            in_round_slopes(frame, [&](const Vec3& m) { return lobe.D(m) * std::max(0., m.dot(u)); });
        const double area = bins.integrate(seen, 300)[0];
        EXPECT_NEAR(lobe.visible_area(u), area, kMidpoint * std::max(area, frame.l11 + frame.l22));
        EXPECT_LE(lobe.G1(u) * lobe.visible_area(u), u.z() * (1 + 1e-12));
        if (frame.centre.norm() == 0) {
          EXPECT_NEAR(lobe.G1(u) * lobe.visible_area(u), u.z(), 1e-12);
        }
      }
  }
}

TYPED_TEST(SlopeLobes, NothingIsBelowTheHorizon) {
  const TypeParam lobe(slope_frame({0.5, 0.2, 0.3, 0.1, 0}));
  EXPECT_EQ(lobe.D(direction(kPi / 2 + 0.1, 0)), 0);
  EXPECT_EQ(lobe.pdf(direction(kPi / 2 + 0.1, 0)), 0);
  EXPECT_EQ(lobe.G1(direction(kPi / 2 + 0.1, 0)), 0);
}

// Widths 1e-5…1e3, ratios to 1e5, tilts to within 1e-5 of the horizon: finite, positive, drawn from the upper
// hemisphere.
TYPED_TEST(SlopeLobes, ZooIsFinite) {
  for (const double alpha_x : {1e-5, 1e-3, 1., 1e3})
    for (const double ratio : {1., 1e-2, 1e-5})
      for (const double tilt : {0., 0.3, 1.5, 1.57, kPi / 2 - 1e-5}) {
        if (alpha_x * ratio < 1e-5) continue;
        const TypeParam lobe(slope_frame({alpha_x, alpha_x * ratio, tilt, tilt / 3, 0.7}));
        for (std::uint64_t k = 0; k < 40; ++k) {
          const auto [a, b] = random_uniform(3, 0, k);
          const Vec2 xi = k == 0 ? Vec2(0, 0) : k == 1 ? Vec2(1 - 0x1p-53, 0.5) : Vec2(a, b);
          const Vec3 u = k < 4 ? direction(kPi / 2 - std::pow(10., -4. * static_cast<double>(k)), a)
                               : random_direction(4, k);
          const double area = lobe.visible_area(u), g1 = lobe.G1(u);
          EXPECT_GE(area, 0);
          EXPECT_LE(area, 1e200);
          EXPECT_GE(g1, 0);
          EXPECT_LE(g1, 1);
          const auto is_upper = [](const Vec3& m) { return std::abs(m.norm() - 1) < 1e-12 && m.z() >= 0; };
          const Vec3 m = lobe.sample(xi), seen = lobe.sample_visible(u, xi);
          EXPECT_TRUE(is_upper(m)) << alpha_x << " " << ratio << " " << tilt << " " << k;
          EXPECT_TRUE(is_upper(seen)) << alpha_x << " " << ratio << " " << tilt << " " << k;
          for (const Vec3& d : {m, seen, u}) {
            EXPECT_GE(lobe.D(d), 0);
            EXPECT_LE(lobe.D(d), 1e60);
            EXPECT_GE(lobe.pdf_visible(u, d), 0);
          }
        }
      }
}

TEST(Ellipsoid, IsThePrintedFormula) {
  constexpr double kRounding = 1e-11;
  for (std::uint64_t k = 0; k < 500; ++k) {
    const EllipsoidParameters p = mild_parameters(k);
    const Ellipsoid lobe(slope_frame(p));
    const Vec3 m = random_direction(2, k);
    EXPECT_NEAR(lobe.D(m) / testing::printed_ellipsoid_D(p, m), 1, kRounding);
    EXPECT_NEAR(lobe.G1(m), testing::printed_ellipsoid_G1(p, m), kRounding);
  }
}

// Against the printed formula in 50 digits. What can be asked for is what the tilt's and the direction's own
// last digit moves, measured in widths.
TEST(Ellipsoid, ZooIsRight) {
  for (const double alpha_x : {1e-5, 1e-3, 1., 1e3})
    for (const double ratio : {1., 1e-2, 1e-5})
      for (const double tilt : {0., 0.3, 1.5, kPi / 2 - 1e-5}) {
        if (alpha_x * ratio < 1e-5) continue;
        const EllipsoidParameters p = {alpha_x, alpha_x * ratio, tilt, tilt / 3, 0.7};
        const Ellipsoid lobe(slope_frame(p));
        for (std::uint64_t k = 0; k < 30; ++k) {
          const auto [a, b] = random_uniform(3, 0, k);
          const Vec3 m = k < 15 ? lobe.sample({a, b}) : random_direction(5, k);
          const double narrow = std::min({p.alpha_x, p.alpha_y, 1.}), wide = std::max(p.alpha_x, 1.);
          const double tolerance = 64 * 2.2e-16 * wide / narrow;
          EXPECT_NEAR(lobe.D(m) / testing::printed_ellipsoid_D(p, m), 1, std::max(1e-11, tolerance))
              << alpha_x << " " << ratio << " " << tilt << " " << m.transpose();
          EXPECT_NEAR(lobe.G1(m) / testing::printed_ellipsoid_G1(p, m), 1, std::max(1e-11, tolerance));
        }
      }
}

TEST(Ellipsoid, SpecialCasesAreTheTextbooks) {
  const double ax = 0.4, ay = 0.15;
  for (std::uint64_t k = 0; k < 100; ++k) {
    const Vec3 m = random_direction(6, k);
    // [Burley12 Eq. 13], [Walter07 Eqs. 33, 34].
    const double e = m.x() * m.x() / (ax * ax) + m.y() * m.y() / (ay * ay) + m.z() * m.z();
    EXPECT_NEAR(gtr2_anisotropic(ax, ay).D(m) * kPi * ax * ay * e * e, 1, 1e-12);
    const double tan2 = (1 - m.z() * m.z()) / (m.z() * m.z());
    EXPECT_NEAR(ggx(ax).G1(m), 2 / (1 + std::sqrt(1 + ax * ax * tan2)), 1e-12);
  }
}

// A skewed lobe that leans away is clamped: less area is seen than the mean plane has [Dong15 Eq. 14].
TEST(Ellipsoid, SkewedLobesAreClamped) {
  const Ellipsoid lobe(slope_frame({0.3, 0.3, 0.3, 0, 0}));
  int clamped = 0;
  for (std::uint64_t k = 0; k < 200; ++k) {
    const Vec3 u = random_direction(8, k);
    const double seen = lobe.G1(u) * lobe.visible_area(u) / u.z();
    EXPECT_LE(seen, 1 + 1e-12);
    clamped += seen < 0.99 ? 1 : 0;
    if (lobe.G1(u) < 1) {
      EXPECT_NEAR(seen, 1, 1e-12);
    }
  }
  EXPECT_GT(clamped, 20);
}

/// Two numbers that should be uniform in [0, 1), of each of many visible samples, by chi-square.
template <typename Uniforms>
void expect_uniform(std::uint64_t seed, const Uniforms& uniforms) {
  constexpr int kSamples = 20000, kBins = 20;
  const auto bin = [](double u) { return static_cast<std::size_t>(std::clamp(u * kBins, 0., kBins - 1.)); };
  std::vector<double> first(kBins, 0.), second(kBins, 0.);
  for (std::uint64_t k = 0; k < kSamples; ++k) {
    const auto [a, b] = random_uniform(seed, 0, k);
    const Vec2 u = uniforms(Vec2(a, b));
    ASSERT_FALSE(u.hasNaN());
    first[bin(u.x())] += 1;
    second[bin(u.y())] += 1;
  }
  const std::vector<double> expected(kBins, kSamples / kBins);
  EXPECT_GT(testing::chi_square_p(first, expected), 1e-4);
  EXPECT_GT(testing::chi_square_p(second, expected), 1e-4);
}

// Leaning away by k ≫ 1 widths, the slopes x = −v_1/k > 1 that are seen have density ∝ (x − 1)/x³, so (1 −
// 1/x)² is uniform, and y = v_2/v_1 given x has density (2/π)/(1 + y²)².
TEST(Ellipsoid, FarTailsAreSampled) {
  constexpr double kLean = 1e5;
  expect_uniform(11, [](const Vec2& u) {
    const Vec2 v = HemisphereShape::sample_visible({1, 0, -kLean}, {u.x(), u.y()});
    const double x = -v.x() / kLean, y = v.y() / v.x();
    EXPECT_GT(x, 1 - 1e-9);
    return Vec2((1 - 1 / x) * (1 - 1 / x), 0.5 + (std::atan(y) + y / (1 + y * y)) / kPi);
  });
}

// The Gaussian's far tail, x = −v_1 = k + w: for k ≫ 1 w·2k has the density w'e^{−w'}.
TEST(Beckmann, FarTailsAreSampled) {
  constexpr double kLean = 1e4;
  expect_uniform(12, [](const Vec2& u) {
    const Vec2 v = GaussianShape::sample_visible({1, 0, -kLean}, {u.x(), u.y()});
    const double w = 2 * kLean * (-v.x() - kLean);
    return Vec2(1 - (1 + w) * std::exp(-w), (1 + std::erf(v.y())) / 2);
  });
}

TEST(Beckmann, IsTheTextbooks) {
  const double ax = 0.4, ay = 0.15;
  const Beckmann lobe(slope_frame({ax, ay, 0, 0, 0}));
  for (std::uint64_t k = 0; k < 100; ++k) {
    const Vec3 m = random_direction(6, k);
    const double z2 = m.z() * m.z();
    const double e = (m.x() * m.x() / (ax * ax) + m.y() * m.y() / (ay * ay)) / z2;
    EXPECT_NEAR(lobe.D(m), std::exp(-e) / (kPi * ax * ay * z2 * z2), 1e-12 * lobe.D(m));
    // Smith's Λ for Gaussian slopes, a = 1/(α(φ)tanθ).
    const double a = m.z() / std::sqrt(ax * ax * m.x() * m.x() + ay * ay * m.y() * m.y());
    const double lambda = (std::exp(-a * a) / (a * std::sqrt(kPi)) - boost::math::erfc(a)) / 2;
    EXPECT_NEAR(lobe.G1(m), 1 / (1 + lambda), 1e-12);
  }
}

// Leaning away by k standard deviations, only a tail e^{−k²} of the slopes is seen; the area keeps its
// digits.
TEST(Beckmann, TailsKeepTheirDigits) {
  for (const double c : {-0.5, -2., -5., -9., -20.}) {
    const auto tail = [&](double w) { return w * std::exp(-w * w + 2 * c * w); };
    const double expected = std::exp(-c * c) / std::sqrt(kPi) *
                            boost::math::quadrature::exp_sinh<double>().integrate(tail, 1e-14);
    EXPECT_NEAR(GaussianShape::visible_area({1, 0, c}) / expected, 1, 1e-11) << c;
  }
}

using Real = long double;

/// Seen from (across, 0, z): ∫(z − v·across)₊·e^{−v²}/√π dv.
Real gaussian_visible_area(const Real& across, const Real& z) {
  const Real c = z / across;
  return across * (std::exp(-c * c) / std::sqrt(std::numbers::pi_v<Real>) + c * std::erfc(-c)) / 2;
}

// In nineteen digits, down to 0.001° above the horizon. What can be asked for is what the last digit of the
// terms of v and u' moves.
TEST(Beckmann, ZooIsRight) {
  constexpr double kRounding = 1e-11, kDigit = 4 * 2.2e-16;
  for (const double alpha_x : {1e-5, 1e-3, 1., 1e3})
    for (const double ratio : {1., 1e-2, 1e-5})
      for (const double tilt : {0., 0.3, 1.5, kPi / 2 - 1e-5}) {
        if (alpha_x * ratio < 1e-5) continue;
        const SlopeFrame f = slope_frame({alpha_x, alpha_x * ratio, tilt, tilt / 3, 0.7});
        const Beckmann lobe(f);
        const Real tx = f.centre.x(), ty = f.centre.y();
        for (const double above : {90., 45., 1., 0.1, 0.01, 0.001})
          for (std::uint64_t k = 0; k < 3; ++k) {
            const auto [a, b] = random_uniform(13, 0, k);
            const Vec3 u = direction((90 - above) * kPi / 180, 2 * kPi * b);
            const Real x = f.l11 * Real(u.x()) + f.l21 * Real(u.y()), y = f.l22 * Real(u.y()),
                       across = std::hypot(x, y), z = u.z() - tx * u.x() - ty * u.y();
            const Real dz = kDigit * Real(u.z() + std::abs(tx * u.x()) + std::abs(ty * u.y())),
                       da = kDigit * Real(std::abs(f.l11 * u.x()) + std::abs(f.l21 * u.y()) + f.l22);
            const Real area = gaussian_visible_area(across, z);
            if (across > da && area > 1e-280) {
              const Real moves =
                  gaussian_visible_area(across + da, z + dz) - gaussian_visible_area(across - da, z - dz);
              const double tolerance = std::max(kRounding, static_cast<double>(std::abs(moves) / area));
              EXPECT_LE(std::abs(static_cast<double>(lobe.visible_area(u) / area - 1)), tolerance)
                  << alpha_x << " " << ratio << " " << tilt << " " << above;
            }
            const Vec3 m = lobe.sample({a, b});
            const Real v1 = (m.x() + tx * m.z()) / f.l11, v2 = (m.y() + ty * m.z() - f.l21 * v1) / f.l22,
                       mz = m.z(), e = (v1 * v1 + v2 * v2) / (mz * mz);
            const Real d = std::exp(-e) / (std::numbers::pi_v<Real> * f.l11 * f.l22 * mz * mz * mz * mz);
            const double widths = std::max(1., f.centre.norm()) / std::min({f.l11, f.l22, 1.}) *
                                  (1 + std::abs(f.l21) / f.l11) / m.z();
            EXPECT_LE(std::abs(static_cast<double>(lobe.D(m) / d - 1)),
                      std::max(kRounding, 16 * kDigit * widths))
                << alpha_x << " " << ratio << " " << tilt;
          }
      }
}

TEST(Beckmann, GaussianSurfaceUnderAWindow) {
  const double sigma_h = 0.3, tau = 3, filter = 1;
  const Beckmann plain = gaussian_surface_normals({sigma_h, tau, tau}),
                 filtered = gaussian_surface_normals({sigma_h, tau, tau, filter});
  EXPECT_NEAR(plain.frame().l11, 2 * sigma_h / tau, 1e-15);
  EXPECT_NEAR(filtered.frame().l11, 2 * sigma_h * tau / (tau * tau + 4), 1e-15);
  const Beckmann brushed = gaussian_surface_normals({sigma_h, 10, 2});
  EXPECT_NEAR(brushed.frame().l11, 2 * sigma_h / 10, 1e-15);
  EXPECT_NEAR(brushed.frame().l22, 2 * sigma_h / 2, 1e-15);
  EXPECT_THROW(gaussian_surface_normals({0, 1, 1}), InputError);
  EXPECT_THROW(gaussian_surface_normals({1, 1, -1}), InputError);
}

}  // namespace
}  // namespace micro
