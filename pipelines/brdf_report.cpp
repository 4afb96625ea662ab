#include "pipelines/brdf_report.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "brdf/colour.h"
#include "core/error.h"
#include "core/parallel.h"

namespace micro {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// The azimuth of wi, which along the normal has none of its own.
double azimuth_of(const Vec3& wi, const BrdfRequest& request) {
  return wi.head<2>().norm() > 0 ? std::atan2(wi.y(), wi.x()) : request.azimuth;
}

BrdfSlice slice_of(const AnyBrdf& model, const Vec3& wi, double phi_i, double plane,
                   const std::vector<double>& lambda_um) {
  constexpr int kPerDegree = 10, kHalf = 90 * kPerDegree - 1;
  const Vec2 away(-std::cos(phi_i + plane), -std::sin(phi_i + plane));
  BrdfSlice slice{wi, phi_i, plane, {}, std::vector<std::vector<double>>(lambda_um.size())};
  for (int k = -kHalf; k <= kHalf; ++k)
    slice.theta_o.push_back(k * kDegree / kPerDegree);
  parallel_for(static_cast<std::int64_t>(lambda_um.size()), [&](std::int64_t c) {
    const auto colour = static_cast<std::size_t>(c);
    for (const double theta : slice.theta_o)
      slice.f[colour].push_back(model.f(
          wi, {std::sin(theta) * away.x(), std::sin(theta) * away.y(), std::cos(theta)}, lambda_um[colour]));
  });
  return slice;
}

BrdfSpectrum spectrum_of(const AnyBrdf& model, const Vec3& wi, int wavelengths, double tolerance) {
  const ColourWeights weights(visible_wavelengths(wavelengths));
  BrdfSpectrum spectrum{weights.lambda_um(), {}, {}, {}};
  std::vector<double> reflectance;
  for (const double lambda : weights.lambda_um()) {
    spectrum.albedo.push_back(albedo(model, wi, lambda, tolerance));
    reflectance.push_back(spectrum.albedo.back().value);
  }
  spectrum.xyz = weights.xyz(reflectance);
  spectrum.linear_rgb = linear_srgb(spectrum.xyz);
  return spectrum;
}

/// Refuses light that the tables of D_K are not for.
void require_light(const BrdfModel& model, const std::vector<double>& lambda_um) {
  constexpr double kRounding = 1e-9;  // of a wavelength
  if (!model.light_um) return;
  const auto [shortest, longest] = *model.light_um;
  for (const double lambda : lambda_um)
    if (!(lambda >= shortest * (1 - kRounding) && lambda <= longest * (1 + kRounding))) {
      std::ostringstream sentence;
      sentence << "the tables of D_K are for light from " << shortest << " to " << longest << " um, not of "
               << lambda << " um: give --lambda within, or take D_K at more wavelengths";
      throw InputError(sentence.str());
    }
}

}  // namespace

BrdfReport evaluate_brdf(const BrdfModel& model, const std::string& material, const BrdfRequest& request) {
  BrdfReport report{request, model.description, material, {}, {}, {}, {}, {}, {}};
  const std::vector<double>& lambda = request.lambda_um;
  require_light(model, lambda);
  const double middle = lambda[lambda.size() / 2];
  for (const Vec3& wi : request.wi) {
    for (const double plane : request.planes)
      report.slices.push_back(slice_of(model.metal, wi, azimuth_of(wi, request), plane, lambda));
    if (!request.albedo) continue;
    report.albedo.emplace_back();
    for (const double each : lambda)
      report.albedo.back().push_back(albedo(model.metal, wi, each, *request.albedo));
  }
  if (request.spectrum > 0 && !request.wi.empty())
    report.spectrum =
        spectrum_of(model.metal, request.wi.front(), request.spectrum, request.spectrum_tolerance);
  if (request.furnace) {
    report.furnace = white_furnace(model.mirror, middle, *request.furnace);
    report.reciprocity = reciprocity(model.metal, middle);
  }
  if (request.table) {
    const Stopwatch watch;
    auto table = half_angle_table(model.metal, lambda, *request.table);
    const auto values = static_cast<std::int64_t>(table.size());
    report.table = {std::move(table), 0, {watch.seconds(), values}};
  }
  return report;
}

}  // namespace micro
