// The tables are read as their publication says [Dupuy18], by code that shares nothing with what wrote them.
#include "brdf/measured_tables.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "brdf/fresnel.h"
#include "brdf/microfacet.h"
#include "core/random.h"
#include "distribution/ellipsoid.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;

/// A position between nodes 0 … n−1: the lower one, and how far on.
struct Between {
  std::size_t low;
  double part;
};

Between between(double x, std::size_t n) {
  const auto low = static_cast<std::size_t>(std::clamp(std::floor(x), 0., static_cast<double>(n - 2)));
  return {low, std::clamp(x - static_cast<double>(low), 0., 1.)};
}

double bilinear(const std::vector<double>& t, std::size_t rows, std::size_t cols, double x, double y) {
  const Between c = between(x * static_cast<double>(cols - 1), cols),
                r = between(y * static_cast<double>(rows - 1), rows);
  const auto v = [&](std::size_t j, std::size_t i) { return t[(r.low + j) * cols + c.low + i]; };
  return (1 - r.part) * ((1 - c.part) * v(0, 0) + c.part * v(0, 1)) +
         r.part * ((1 - c.part) * v(1, 0) + c.part * v(1, 1));
}

/// A reader of the tables.
class Reader {
 public:
  explicit Reader(const MeasuredTables& tables) : t_(tables), g_(tables.grid) {}

  /// f·cosθ_o of the one wavelength, and the density that drawing visible normals has there.
  std::pair<double, double> evaluate(const Vec3& wi, const Vec3& wo) const {
    const Vec3 m = (wi + wo).normalized();
    const double theta_i = std::acos(wi.z()), phi_i = std::atan2(wi.y(), wi.x());
    double phi_m = std::atan2(m.y(), m.x());
    if (g_.phi_i == 1) phi_m -= phi_i;
    double uy = (phi_m + kPi) / (2 * kPi);
    uy -= std::floor(uy);
    const double theta_m = std::acos(std::min(1., m.z())), ux = std::sqrt(2 * theta_m / kPi);
    const std::vector<double> vndf = slice(t_.vndf, theta_i, phi_i, g_.vndf_phi * g_.vndf_theta, true);
    const auto [sx, sy] = invert(vndf, ux, uy);
    const std::vector<double> spectra = slice(t_.spectra, theta_i, phi_i, g_.samples * g_.samples, false);
    const double d = bilinear({t_.ndf.begin(), t_.ndf.end()}, g_.ndf_phi, g_.ndf_theta, ux, uy);
    const double sigma = bilinear({t_.sigma.begin(), t_.sigma.end()}, g_.sigma_phi, g_.sigma_theta,
                                  std::sqrt(2 * theta_i / kPi), (phi_i + kPi) / (2 * kPi));
    const double value = bilinear(spectra, g_.samples, g_.samples, sx, sy) * d / (4 * sigma);
    const double density = bilinear(vndf, g_.vndf_phi, g_.vndf_theta, ux, uy) /
                           (2 * kPi * kPi * ux * std::sin(theta_m) * 4 * wi.dot(m));
    return {value, density};
  }

 private:
  /// A table at a direction of light; densities are brought to mass 1 first.
  std::vector<double> slice(const std::vector<float>& table, double theta_i, double phi_i, std::size_t size,
                            bool normalise) const {
    const double last = static_cast<double>(t_.theta_i.back());
    const Between a = between(theta_i / last * static_cast<double>(g_.theta_i - 1), g_.theta_i);
    std::vector<double> result(size);
    const auto add = [&](std::size_t p, std::size_t k, double weight) {
      const float* from = &table[(p * g_.theta_i + k) * size];
      const double scale = normalise ? weight / mass(from) : weight;
      for (std::size_t n = 0; n < size; ++n)
        result[n] += scale * static_cast<double>(from[n]);
    };
    const Between b = g_.phi_i == 1
                          ? Between{0, 0}
                          : between((phi_i + kPi) / (2 * kPi) * static_cast<double>(g_.phi_i - 1), g_.phi_i);
    for (const std::size_t k : {0u, 1u})
      for (const std::size_t p : {0u, 1u}) {
        const double weight = (k == 1 ? a.part : 1 - a.part) * (p == 1 ? b.part : 1 - b.part);
        if (weight > 0) add(b.low + p, a.low + k, weight);
      }
    return result;
  }

  template <typename T>
  double mass(const T* table) const {
    const std::size_t rows = g_.vndf_phi, cols = g_.vndf_theta;
    double sum = 0;
    for (std::size_t j = 0; j < rows; ++j)
      for (std::size_t i = 0; i < cols; ++i)
        sum += static_cast<double>(table[j * cols + i]) * (i % (cols - 1) == 0 ? 0.5 : 1) *
               (j % (rows - 1) == 0 ? 0.5 : 1);
    return sum / static_cast<double>((rows - 1) * (cols - 1));
  }

  /// The uniform numbers that lead to (x, y): distribution functions of a bilinear density.
  std::pair<double, double> invert(const std::vector<double>& d, double x, double y) const {
    const std::size_t rows = g_.vndf_phi, cols = g_.vndf_theta;
    const auto along = [&](const auto& at, double end, std::size_t nodes) {
      const Between b = between(end * static_cast<double>(nodes - 1), nodes);
      double sum = 0;
      for (std::size_t k = 0; k < b.low; ++k)
        sum += (at(k) + at(k + 1)) / 2;
      return sum + b.part * at(b.low) + b.part * b.part / 2 * (at(b.low + 1) - at(b.low));
    };
    const auto row = [&](std::size_t j) {
      return along([&](std::size_t i) { return d[j * cols + i]; }, 1, cols);
    };
    const Between r = between(y * static_cast<double>(rows - 1), rows);
    const auto at_y = [&](std::size_t i) {
      return (1 - r.part) * d[r.low * cols + i] + r.part * d[(r.low + 1) * cols + i];
    };
    return {along(at_y, x, cols) / along(at_y, 1, cols), along(row, y, rows) / along(row, 1, rows)};
  }

  const MeasuredTables& t_;
  const MeasuredGrid& g_;
};

Vec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// Root of the mean squared relative error of f·cosθ_o over drawn directions: what a renderer's noise would
/// have to hide.
double drawn_error(const AnyBrdf& model, const MeasuredTables& tables) {
  const Reader reader(tables);
  double sum = 0;
  int count = 0;
  for (std::uint64_t k = 0; k < 60; ++k) {
    const auto light = random_uniform(7, 0, k), xi = random_uniform(7, 1, k);
    const Vec3 wi = direction(1.3 * light[0], 2 * kPi * light[1] - kPi);
    const auto drawn = model.sample(wi, 0.55, {xi[0], xi[1]});
    if (!drawn || drawn->wo.z() < 0.05) continue;
    const double want = drawn->f * drawn->wo.z(), got = reader.evaluate(wi, drawn->wo).first;
    sum += std::pow(got / want - 1, 2);
    ++count;
  }
  EXPECT_GT(count, 30);
  return std::sqrt(sum / count);
}

AnyBrdf metal(const EllipsoidParameters& parameters) {
  return AnyBrdf(Microfacet(Ellipsoid(slope_frame(parameters)), Fresnel(std::complex(0.27, 3.4))));
}

TEST(MeasuredTables, IsotropicTablesGiveTheModelBack) {
  const AnyBrdf model = metal({0.2, 0.2});
  EXPECT_LT(anisotropy(model, 0.55), 1e-9);
  EXPECT_LT(drawn_error(model, measured_tables(model, {0.55}, MeasuredGrid::isotropic())), 0.02);
}

TEST(MeasuredTables, SkewedTablesGiveTheModelBack) {
  const AnyBrdf model = metal({0.3, 0.15, 0.1, -0.2, 0.4});
  EXPECT_GT(anisotropy(model, 0.55), 0.1);
  EXPECT_LT(drawn_error(model, measured_tables(model, {0.55}, MeasuredGrid())), 0.04);
}

TEST(MeasuredTables, ErrorFallsWithResolution) {
  const AnyBrdf model = metal({0.3, 0.15, 0.1, -0.2, 0.4});
  MeasuredGrid coarse;
  coarse.theta_i = 8;
  coarse.phi_i = 9;
  coarse.samples = 16;
  EXPECT_GT(drawn_error(model, measured_tables(model, {0.55}, coarse)),
            2 * drawn_error(model, measured_tables(model, {0.55}, MeasuredGrid())));
}

// The density over wo with which visible normals are drawn: of a narrow lobe nothing goes below the horizon.
TEST(MeasuredTables, DensityOfDrawnDirectionsIntegratesToOne) {
  const AnyBrdf model = metal({0.05, 0.05});
  MeasuredGrid grid = MeasuredGrid::isotropic();
  grid.samples = 8;
  const MeasuredTables tables = measured_tables(model, {0.55}, grid);
  const Reader reader(tables);
  const Vec3 wi = direction(0.3, 0.2);
  double sum = 0;
  constexpr int kTheta = 90, kPhi = 90;
  for (int a = 0; a < kTheta; ++a)
    for (int b = 0; b < kPhi; ++b) {
      const double theta = (a + 0.5) / kTheta * kPi / 2, phi = (b + 0.5) / kPhi * 2 * kPi;
      sum += reader.evaluate(wi, direction(theta, phi)).second * std::sin(theta);
    }
  EXPECT_NEAR(sum * (kPi / 2 / kTheta) * (2 * kPi / kPhi), 1, 0.02);
}

TEST(MeasuredTables, NeedlesAndGrazingLightAreFinite) {
  for (const double alpha : {1e-3, 1.}) {
    MeasuredGrid grid = MeasuredGrid::isotropic();
    grid.samples = 16;
    const MeasuredTables t = measured_tables(metal({alpha, alpha}), {0.45, 0.65}, grid);
    for (const auto* table : {&t.ndf, &t.sigma, &t.vndf, &t.luminance, &t.spectra})
      for (const float value : *table)
        ASSERT_TRUE(value >= 0 && std::isfinite(value)) << alpha;
  }
}

}  // namespace
}  // namespace micro
