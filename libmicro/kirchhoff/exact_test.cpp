#include "kirchhoff/exact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include "core/error.h"
#include "testing/cosine_surface.h"

namespace micro {
namespace {

using Real50 = boost::multiprecision::cpp_bin_float_50;

/// What the issue asks of one triangle, in units of the envelope min(1, 1/spread).
constexpr double kTriangleTolerance = 1e-12;

struct Complex50 {
  Real50 re = 0, im = 0;
};

/// The mean over a triangle of e^{−iφ} with corner phases p: twice the second divided difference in 50
/// digits, or, where phases come close, the power series Σ (−i)^k h_k·2/(k+2)!. Either way at least 25 digits
/// survive.
Complex50 reference_mean(const std::array<Real50, 3>& p) {
  const Real50 a = p[1] - p[0], b = p[2] - p[0];
  const auto size = [](const Real50& x) { return abs(x); };
  const Real50 largest = std::max({size(a), size(b), size(Real50(a - b))});
  const Real50 smallest = std::min({size(a), size(b), size(Real50(a - b))});
  Complex50 relative;
  if (largest < 40 && smallest < 1e-3) {
    Real50 h = 1, power = 1, factor = 1;  // h_k(a, b), b^k, 2/(k+2)!
    for (int k = 0; k < 250; ++k) {
      const Real50 term = h * factor;
      if (k % 2 == 0) relative.re += (k % 4 == 0 ? term : Real50(-term));
      if (k % 2 == 1) relative.im += (k % 4 == 3 ? term : Real50(-term));
      power *= b;
      h = a * h + power;
      factor /= k + 3;
    }
  } else if (smallest == 0) {
    // Two phases equal, at x, the third at y: e^{−ix}·2·(1 − ic − e^{−ic})/c², c = y − x.
    const bool first_two = size(a) <= size(b) && size(a) <= size(Real50(a - b));
    const bool first_last = !first_two && size(b) <= size(Real50(a - b));
    const Real50 x = first_two || first_last ? Real50(0) : a;
    const Real50 y = first_two ? b : first_last ? a : Real50(0);
    const Real50 c = y - x;
    const Real50 re = 2 * (1 - cos(c)) / (c * c), im = 2 * (sin(c) - c) / (c * c);
    relative.re = cos(x) * re + sin(x) * im;
    relative.im = cos(x) * im - sin(x) * re;
  } else {
    const std::array<Real50, 3> x = {0, a, b};
    for (int k = 0; k < 3; ++k) {
      const Real50 product = (x[k] - x[(k + 1) % 3]) * (x[k] - x[(k + 2) % 3]);
      // (−i)^{-2} = −1: divided difference in −iφ of the exponential
      relative.re += -2 * cos(x[k]) / product;
      relative.im += 2 * sin(x[k]) / product;
    }
  }
  return {cos(p[0]) * relative.re + sin(p[0]) * relative.im,
          cos(p[0]) * relative.im - sin(p[0]) * relative.re};
}

struct Reference {
  Complex50 field;
  double envelope = 0;  ///< Σ |q||a_T| min(1, 1/spread)
};

/// F(q) as kirchhoff.h defines it, triangle by triangle in 50 digits.
Reference reference_field(const HeightField& surface, const Vec3& q) {
  Reference total;
  const auto triangle = [&](std::array<std::array<Eigen::Index, 2>, 3> corners) {
    std::array<std::array<Real50, 3>, 3> s;
    std::array<Real50, 3> phase;
    for (int k = 0; k < 3; ++k) {
      const auto [j, i] = corners[k];
      if (is_missing(surface.z(j, i))) return;
      s[k] = {Real50(surface.dx) * i, Real50(surface.dy) * j, Real50(surface.z(j, i))};
      phase[k] = Real50(q.x()) * s[k][0] + Real50(q.y()) * s[k][1] + Real50(q.z()) * s[k][2];
    }
    std::array<Real50, 3> e, f, area;
    for (int k = 0; k < 3; ++k) {
      e[k] = s[1][k] - s[0][k];
      f[k] = s[2][k] - s[0][k];
    }
    Real50 flux = 0, squared = 0;
    for (int k = 0; k < 3; ++k) {
      area[k] = (e[(k + 1) % 3] * f[(k + 2) % 3] - e[(k + 2) % 3] * f[(k + 1) % 3]) / 2;
      flux += Real50(q[k]) * area[k];
      squared += area[k] * area[k];
    }
    const Complex50 mean = reference_mean(phase);
    total.field.re += flux * mean.re;
    total.field.im += flux * mean.im;
    const auto [low, high] = std::minmax_element(phase.begin(), phase.end());
    const double spread = static_cast<double>(Real50(*high - *low));
    total.envelope +=
        q.norm() * std::sqrt(static_cast<double>(squared)) * std::min(1.0, 1 / std::max(spread, 1e-300));
  };
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for (Eigen::Index i = 0; i + 1 < surface.cols(); ++i) {
      triangle({{{j, i}, {j, i + 1}, {j + 1, i + 1}}});
      triangle({{{j, i}, {j + 1, i + 1}, {j + 1, i}}});
    }
  return total;
}

double error_in_envelopes(const HeightField& surface, const Vec3& q) {
  const std::complex<double> got = exact_field(surface, q);
  const Reference want = reference_field(surface, q);
  const double re = static_cast<double>(Real50(Real50(got.real()) - want.field.re));
  const double im = static_cast<double>(Real50(Real50(got.imag()) - want.field.im));
  return std::hypot(re, im) / want.envelope;
}

HeightField cell(double z00, double z01, double z10, double z11, double dx = 1, double dy = 1) {
  HeightField surface;
  surface.dx = dx;
  surface.dy = dy;
  surface.z.resize(2, 2);
  surface.z << static_cast<float>(z00), static_cast<float>(z01), static_cast<float>(z10),
      static_cast<float>(z11);
  return surface;
}

/// Spacings of phase from nothing to hundreds of radians.
const std::vector<double> kSpacings = {0,    1e-16,  1e-12,  1e-9, 1e-7,  1e-5, 1e-4, 1e-3,
                                       1e-2, 0.03,   0.0499, 0.05, 0.051, 0.1,  0.3,  1,
                                       3,    3.1416, 6.2832, 10,   100,   777};

TEST(ExactTriangle, EverySpacingOfPhases) {
  // q = (0, 0, 1): the phases are the heights, so equal, nearly equal and distant phases are set at will.
  // Common phases are added through a height offset that float holds exactly.
  double worst = 0;
  for (const double a : kSpacings)
    for (const double b : kSpacings)
      for (const double sign : {-1.0, 1.0})
        for (const double tiny : {0.0, 1e-13, -1e-6}) {
          const double second = sign * b + tiny;
          worst = std::max(worst, error_in_envelopes(cell(0, a, NAN, second), Vec3(0, 0, 1)));
          worst = std::max(worst, error_in_envelopes(cell(0, NAN, a, second), Vec3(0, 0, 1)));
          worst = std::max(worst, error_in_envelopes(cell(a, NAN, 0, a + second), Vec3(0, 0, 1)));
        }
  EXPECT_LE(worst, kTriangleTolerance);
}

TEST(ExactTriangle, NearlyEqualPhasesInEveryPair) {
  double worst = 0;
  for (const double gap : {0.0, 1e-15, 1e-10, 1e-6, 1e-3})
    for (const double far : {1e-3, 0.5, 20.0, 300.0})
      for (const Vec3& phases :
           {Vec3(0, gap, far), Vec3(0, far, gap), Vec3(far, 0, gap), Vec3(gap, far, 0)}) {
        // In-plane components of q make phases the heights cannot hold in float: φ01 − φ00 = q_x, φ11 − φ01 =
        // q_y.
        const Vec3 q(phases[1] - phases[0], phases[2] - phases[1], 0.7);
        worst = std::max(worst, error_in_envelopes(cell(0, 0, NAN, 0), q));
        worst = std::max(worst, error_in_envelopes(cell(0.25, 0.25, NAN, 0.25), q));
      }
  EXPECT_LE(worst, kTriangleTolerance);
}

TEST(ExactTriangle, DegenerateTriangles) {
  // Facets seen edge-on (q·a = 0), needles, and slopes of a million.
  for (const Vec3& q : {Vec3(1, 0, 1), Vec3(0.3, 0.4, 0), Vec3(1e-9, 0, 1e-9)}) {
    EXPECT_LE(error_in_envelopes(cell(0, 1, 0, 1), q), kTriangleTolerance);
    EXPECT_LE(error_in_envelopes(cell(0, 1e6, NAN, -1e6), q), 1e-9);  // phases of 1e6 rad: ε·1e6
    EXPECT_LE(error_in_envelopes(cell(0, 1e-9, 0, 0, 1e-9, 1e9), q), kTriangleTolerance);
  }
}

HeightField bumpy(int rows, int cols, double dx, double dy, double amplitude) {
  HeightField surface;
  surface.dx = dx;
  surface.dy = dy;
  surface.z.resize(rows, cols);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < cols; ++i)
      surface.z(j, i) = static_cast<float>(amplitude * (std::sin(0.7 * i + 0.3 * j) + std::cos(0.2 * i * j)));
  return surface;
}

TEST(ExactField, EqualsTheDefinitionInFiftyDigits) {
  HeightField surface = bumpy(38, 21, 0.11, 0.13, 0.2);
  for (const Vec3& h : {Vec3(0, 0, 1), Vec3(0.6, 0, 0.8), Vec3(-0.48, 0.64, 0.6), Vec3(0.6, -0.8, 0)})
    EXPECT_LE(error_in_envelopes(surface, wave_vector(h, 0.555)), kTriangleTolerance);
  surface.z(3, 4) = surface.z(20, 20) = surface.z(37, 0) = surface.z(15, 15) = surface.z(15, 16) = kMissing;
  for (const Vec3& h : {Vec3(0, 0, 1), Vec3(0.6, 0, 0.8), Vec3(-0.48, 0.64, 0.6), Vec3(0.6, -0.8, 0)}) {
    EXPECT_LE(error_in_envelopes(surface, wave_vector(h, 0.555)), kTriangleTolerance);
    EXPECT_LE(error_in_envelopes(surface, wave_vector(h, 1e6)), kTriangleTolerance);
    EXPECT_LE(error_in_envelopes(surface, wave_vector(h, 0.01)), 1e-11);  // phases of 5e3 rad: ε·5e3
  }
}

TEST(ExactField, VanishesWithQ) {
  EXPECT_EQ(exact_field(bumpy(5, 7, 1, 1, 1), Vec3(0, 0, 0)), 0.0);
}

/// Fresnel amplitude of a metal for polarisation s, incidence cosine c, index n + ik (Born & Wolf, §1.5.2
/// with complex n).
std::complex<double> fresnel_s(double c, std::complex<double> index) {
  const std::complex<double> t = std::sqrt(index * index - (1 - c * c));
  return (c - t) / (c + t);
}

TEST(ExactField, ReflectanceMayVaryOverTheSurface) {
  // Copper at 0.5486 µm: n = 1.02, k = 2.59 (Johnson & Christy, Phys. Rev. B 6, 4370, 1972, 2.26 eV).
  const std::complex<double> copper(1.02, 2.59);
  const Vec3 wi = Vec3(0.5, 0.1, 0.8).normalized(), wo = Vec3(-0.3, 0.2, 0.9).normalized();
  const Vec3 q = 2 * M_PI / 0.5486 * (wi + wo);
  HeightField surface = bumpy(40, 31, 0.3, 0.25, 0.2);
  surface.z(7, 9) = kMissing;
  // A constant comes out in front.
  const std::complex<double> r0(0.3, -0.8);
  const auto constant = exact_field(surface, q, [&](const Vec3&) { return r0; });
  EXPECT_LE(std::abs(constant - r0 * exact_field(surface, q)), 1e-13 * q.norm() * 120);
  // Two halves, each of its own slope, are two plates: linear in R, and R depends on the facet alone.
  const auto of_facet = [&](const Vec3& m) { return fresnel_s(std::max(0.0, wi.dot(m)), copper); };
  HeightField roof = bumpy(3, 3, 1, 1, 0);
  roof.z.col(1).setConstant(0.5f);
  HeightField left = roof, right = roof;
  left.z.col(2).setConstant(kMissing);
  right.z.col(0).setConstant(kMissing);
  const Vec3 left_normal = Vec3(-0.5, 0, 1).normalized(), right_normal = Vec3(0.5, 0, 1).normalized();
  const auto want =
      of_facet(left_normal) * exact_field(left, q) + of_facet(right_normal) * exact_field(right, q);
  EXPECT_LE(std::abs(exact_field(roof, q, of_facet) - want), 1e-13 * q.norm() * 4);
}

/// √(Σ(|R(h)F|² − |F_R|²)²/Σ|F_R|⁴) over directions: R of the half direction [Dong15 Eqs. 6, 7] for that of
/// each facet [Eq. 3].
double constant_reflectance_error(const HeightField& surface) {
  const std::complex<double> copper(1.02, 2.59);
  const Vec3 wi = Vec3(1, 0, 1).normalized();
  double difference = 0, total = 0;
  for (int n = 0; n < 64; ++n) {
    const double x = -0.6 + 0.075 * (n % 8 - 3.5), y = 0.075 * (n / 8 - 3.5);
    const Vec3 wo(x, y, std::sqrt(1 - x * x - y * y)), q = 2 * M_PI / 0.5486 * (wi + wo);
    const double varying = std::norm(
        exact_field(surface, q, [&](const Vec3& m) { return fresnel_s(std::max(0.0, wi.dot(m)), copper); }));
    const double constant = std::norm(fresnel_s(wi.dot(q.normalized()), copper) * exact_field(surface, q));
    difference += (constant - varying) * (constant - varying);
    total += varying * varying;
  }
  return std::sqrt(difference / total);
}

// A flat plate has one normal, that of its only direction of any light; slopes of 0.14 cost a fraction of a
// percent of D, slopes of 0.9 percents (docs/zoo.md).
TEST(ExactField, ConstantReflectanceCostsLittleOnGentleSlopes) {
  const double rough =
      constant_reflectance_error(testing::make_gaussian_surface({.rows = 96, .cols = 128}, 1));
  const double steep = constant_reflectance_error(
      testing::make_gaussian_surface({.rows = 96, .cols = 128, .rms = 1, .tau_x = 1.5, .tau_y = 1.5}, 1));
  EXPECT_GT(rough, 5e-4);
  EXPECT_LE(rough, 2e-2);
  EXPECT_GT(steep, rough);
  EXPECT_LE(steep, 0.15);
}

TEST(ExactField, DoesNotDependOnThreadsOrOnBatching) {
  const HeightField surface = bumpy(100, 33, 0.11, 0.11, 0.2);
  const std::vector<Vec3> q = {wave_vector(Vec3(0, 0.6, 0.8), 0.5), wave_vector(Vec3(0.28, 0, 0.96), 0.5)};
  const auto both = exact_field(surface, q);
  EXPECT_EQ(both[0], exact_field(surface, q[0]));
  EXPECT_EQ(both[1], exact_field(surface, q[1]));
}

TEST(ExactField, EmptySurfacesGiveZeroAndNoDensity) {
  HeightField surface = bumpy(4, 5, 1, 1, 1);
  surface.z.setConstant(kMissing);
  EXPECT_EQ(exact_field(surface, Vec3(1, 2, 3)), 0.0);
  EXPECT_THROW(exact_density(surface, Vec3(1, 2, 3)), InputError);
  EXPECT_EQ(exact_field(bumpy(1, 7, 1, 1, 1), Vec3(1, 2, 3)), 0.0);
  EXPECT_EQ(exact_field(bumpy(7, 1, 1, 1, 1), Vec3(1, 2, 3)), 0.0);
}

TEST(ExactDensity, TiltedPlateIsASincSquared) {
  // A plate with normal m, projected sides Lx, Ly: |F| = (q·m)/m_z·Lx·Ly·|sinc(u)sinc(v)| with u, v half the
  // phase along each side.
  constexpr int kRows = 17, kCols = 40;
  HeightField plate = bumpy(kRows, kCols, 0.125, 0.25, 0);
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < kCols; ++i)
      plate.z(j, i) = static_cast<float>(0.0625 * i - 0.03125 * j);  // slopes 1/2, −1/8: exact in float
  const double lx = 0.125 * (kCols - 1), ly = 0.25 * (kRows - 1);
  const auto sinc = [](double x) { return x == 0 ? 1 : std::sin(x) / x; };
  for (const Vec3& h :
       {Vec3(0, 0, 1), Vec3(-0.5, 0.125, 1).normalized(), Vec3(-0.4, 0.3, 0.8).normalized(), Vec3(1, 0, 0)}) {
    const Vec3 q = wave_vector(h, 0.555);
    const double u = (q.x() + 0.5 * q.z()) * lx / 2, v = (q.y() - 0.125 * q.z()) * ly / 2;
    const double f = (q.z() - 0.5 * q.x() + 0.125 * q.y()) * lx * ly * sinc(u) * sinc(v);
    const double want = f * f / (4 * M_PI * M_PI * lx * ly);
    EXPECT_NEAR(exact_density(plate, q), want, 1e-12 * q.squaredNorm() * lx * ly);
  }
}

}  // namespace
}  // namespace micro
