#include "error_vs_time/brdf_curves.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "brdf/albedo.h"
#include "brdf/colour.h"
#include "brdf/half_angle_table.h"
#include "brdf/kirchhoff_brdf.h"
#include "brdf/metals.h"
#include "brdf/microfacet.h"
#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "distribution/tabulated.h"
#include "height/gaussian_surface.h"
#include "kirchhoff/spectral.h"

namespace micro::bench {
namespace {

using Report = std::function<void(const CurvePoint&)>;

constexpr double kLambda = 0.55;
const Vec3 kLight(std::sqrt(0.75), 0, 0.5);

/// Of all threads: what other programs do on the machine does not count.
double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

CurvePoint point(const std::string& lobe, const std::string& estimator, double asked, double error,
                 double seconds) {
  return {.part = "brdf",
          .surface = lobe,
          .estimator = estimator,
          .asked = asked,
          .error = error,
          .error_core_free = error,
          .seconds = seconds};
}

void report_albedo(const std::string& lobe, const Microfacet<Ellipsoid>& model, const Report& report) {
  constexpr double kReference = 1e-6;
  const double exact = albedo(model, kLight, kLambda, kReference).value;
  for (const double tolerance : {1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5}) {
    const double start = cpu_seconds();
    const Estimate<double> found = albedo(model, kLight, kLambda, tolerance);
    CurvePoint p = point(lobe, "albedo", tolerance, std::abs(found.value - exact), cpu_seconds() - start);
    p.reached = found.error <= tolerance ? CurvePoint::Reached::Yes : CurvePoint::Reached::No;
    report(p);
  }
}

/// D_K of one surface, speckle and all, as a perfect mirror's.
void report_speckle(const Report& report) {
  constexpr double kReference = 3e-5, kTableTolerance = 1e-3;
  const HeightField surface = gaussian_surface({480, 640, 0.11, 0.11}, {0.3, 3, 3, 0}, 1);
  const std::vector<double> lambda_q = {0.5, 0.6};
  std::vector<Tabulated> tables;
  for (const double lambda : lambda_q)
    tables.emplace_back(spectral_table(surface, {1025, 1}, lambda, kTableTolerance).table);
  const KirchhoffBrdf model(SpectrumDensity(lambda_q, tables), gaussian_surface_normals({0.3, 3, 3}),
                            Masking::Smith);
  const double exact = albedo(model, kLight, kLambda, kReference).value;
  const auto report_by = [&](const std::string& name, const auto& albedo_to) {
    for (const double tolerance : {1e-2, 3e-3, 1e-3, 3e-4}) {
      const double start = cpu_seconds();
      const Estimate<double> found = albedo_to(tolerance);
      CurvePoint p =
          point(name, "D_K albedo", tolerance, std::abs(found.value - exact), cpu_seconds() - start);
      p.reached = found.error <= tolerance ? CurvePoint::Reached::Yes : CurvePoint::Reached::No;
      report(p);
    }
  };
  report_by("over the tables", [&](double tolerance) { return albedo(model, kLight, kLambda, tolerance); });
  report_by("by draws", [&](double tolerance) { return sampled_albedo(model, kLight, kLambda, tolerance); });
}

/// (Σ(f' − f)²/Σf²)^½ of another f' over all directions of the viewer, by the model's own samples.
template <typename Other>
double relative_l2(const Microfacet<Ellipsoid>& model, Other&& other) {
  double difference = 0, whole = 0;
  for (std::uint64_t k = 0; k < 20000; ++k) {
    const auto [a, b] = random_uniform(4, 0, k);
    const auto drawn = model.sample(kLight, kLambda, {a, b});
    if (!drawn) continue;
    const double error = other(drawn->wo) - drawn->f;
    difference += error * error / drawn->pdf;
    whole += drawn->f * drawn->f / drawn->pdf;
  }
  return std::sqrt(difference / whole);
}

void report_tables(const std::string& lobe, const Microfacet<Ellipsoid>& model, const Report& report) {
  for (const int size : {65, 129, 257, 513, 1025}) {
    const Microfacet tabulated(Tabulated(tabulate(model.normals(), {size, 1})), model.fresnel());
    const double error = relative_l2(model, [&](const Vec3& wo) { return tabulated.f(kLight, wo, kLambda); });
    const double start = cpu_seconds();
    half_angle_table(tabulated, {0.45, 0.55, 0.65});
    report(point(lobe, "table", size, error, cpu_seconds() - start));
  }
}

/// The bin of wi and wo in a table of an isotropic model, as MERL's own look-up finds it.
std::size_t bin_of(const HalfAngleGrid& grid, const Vec3& wi, const Vec3& wo) {
  const Vec3 h = half_vector(wi, wo), beside = Vec3(-h.y(), h.x(), 0).normalized(), down = beside.cross(h);
  const double pi = std::numbers::pi, phi_d = std::atan2(wi.dot(beside), wi.dot(down));
  const auto bin = [](double part, std::int64_t n) {
    return std::clamp(static_cast<std::int64_t>(part * static_cast<double>(n)), std::int64_t{0}, n - 1);
  };
  const std::int64_t i = bin(std::sqrt(std::acos(h.z()) / (pi / 2)), grid.theta_h),
                     j = bin(std::acos(std::min(1., wi.dot(h))) / (pi / 2), grid.theta_d),
                     k = bin((phi_d < 0 ? phi_d + pi : phi_d) / pi, grid.phi_d);
  return static_cast<std::size_t>((i * grid.theta_d + j) * grid.phi_d + k);
}

void report_half_angle_tables(const std::string& lobe, const Microfacet<Ellipsoid>& model,
                              const Report& report) {
  for (const int n : {11, 23, 45, 90, 180}) {
    const HalfAngleGrid grid{n, n, 2 * n};
    const double start = cpu_seconds();
    const std::vector<float> table = half_angle_table(model, {kLambda}, grid);
    const double seconds = cpu_seconds() - start;
    const double error = relative_l2(
        model, [&](const Vec3& wo) { return static_cast<double>(table[bin_of(grid, kLight, wo)]); });
    report(point(lobe, "half-angle table", n, error, seconds));
  }
}

void report_spectra(const std::string& lobe, const Microfacet<Ellipsoid>& model, const Report& report) {
  constexpr double kTolerance = 2e-4;
  const auto colour = [&](int n) {
    const ColourWeights weights(visible_wavelengths(n));
    std::vector<double> reflectance;
    for (const double lambda : weights.lambda_um())
      reflectance.push_back(albedo(model, kLight, lambda, kTolerance).value);
    return linear_srgb(weights.xyz(reflectance));
  };
  const Vec3 exact = colour(200);
  for (const int n : {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48}) {
    const double start = cpu_seconds();
    const Vec3 found = colour(n);
    report(point(lobe, "spectrum", n, (found - exact).cwiseAbs().maxCoeff(), cpu_seconds() - start));
  }
}

}  // namespace

void brdf_curves(const Report& report) {
  const Fresnel copper(metal("Cu").constants);
  for (const auto& [name, parameters] :
       {std::pair<std::string, EllipsoidParameters>("round lobe", {0.2, 0.2, 0, 0, 0}),
        std::pair<std::string, EllipsoidParameters>("needle", {0.3, 0.03, 0, 0, 0.4})}) {
    const Microfacet model(Ellipsoid(slope_frame(parameters)), copper);
    report_albedo(name, model, report);
    report_tables(name, model, report);
    if (parameters.alpha_x == parameters.alpha_y) report_half_angle_tables(name, model, report);
    report_spectra(name, model, report);
  }
  report_speckle(report);
}

}  // namespace micro::bench
