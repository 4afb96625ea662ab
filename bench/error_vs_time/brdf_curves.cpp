#include "error_vs_time/brdf_curves.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "brdf/albedo.h"
#include "brdf/colour.h"
#include "brdf/half_angle_table.h"
#include "brdf/metals.h"
#include "brdf/microfacet.h"
#include "core/estimate.h"
#include "core/random.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "distribution/tabulated.h"

namespace micro::bench {
namespace {

using Report = std::function<void(const CurvePoint&)>;

constexpr double kLambda = 0.55;
const Vec3 kLight(std::sqrt(0.75), 0, 0.5);

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
    const Estimate<double> found = albedo(model, kLight, kLambda, tolerance);
    CurvePoint p = point(lobe, "albedo", tolerance, std::abs(found.value - exact), found.cost.seconds);
    p.reached = found.error <= tolerance ? CurvePoint::Reached::Yes : CurvePoint::Reached::No;
    report(p);
  }
}

void report_tables(const std::string& lobe, const Microfacet<Ellipsoid>& model, const Report& report) {
  for (const int size : {65, 129, 257, 513, 1025}) {
    const Microfacet tabulated(Tabulated(tabulate(model.normals(), {size, 1})), model.fresnel());
    double difference = 0, whole = 0;
    for (std::uint64_t k = 0; k < 20000; ++k) {
      const auto [a, b] = random_uniform(4, 0, k);
      const auto drawn = model.sample(kLight, kLambda, {a, b});
      if (!drawn) continue;
      const double error = tabulated.f(kLight, drawn->wo, kLambda) - drawn->f;
      difference += error * error / drawn->pdf;
      whole += drawn->f * drawn->f / drawn->pdf;
    }
    const Stopwatch watch;
    half_angle_table(tabulated, {0.45, 0.55, 0.65});
    report(point(lobe, "table", size, std::sqrt(difference / whole), watch.seconds()));
  }
}

void report_spectra(const std::string& lobe, const Microfacet<Ellipsoid>& model, const Report& report) {
  constexpr double kTolerance = 1e-4;
  const auto colour = [&](int n) {
    const ColourWeights weights(visible_wavelengths(n));
    std::vector<double> reflectance;
    for (const double lambda : weights.lambda_um())
      reflectance.push_back(albedo(model, kLight, lambda, kTolerance).value);
    return linear_srgb(weights.xyz(reflectance));
  };
  const Vec3 exact = colour(200);
  for (const int n : {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48}) {
    const Stopwatch watch;
    const Vec3 found = colour(n);
    report(point(lobe, "spectrum", n, (found - exact).cwiseAbs().maxCoeff(), watch.seconds()));
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
    if (name == "round lobe") report_spectra(name, model, report);
  }
}

}  // namespace micro::bench
