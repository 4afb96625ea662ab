#include "pipelines/brdf_exchange.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "brdf/colour.h"
#include "brdf/klems_matrix.h"
#include "brdf/measured_tables.h"
#include "core/error.h"
#include "io/atomic_file.h"
#include "io/merl.h"
#include "io/tensor_file.h"
#include "pipelines/klems_xml.h"
#include "pipelines/origin.h"

namespace micro {
namespace {

/// Rounding leaves this much between a model and itself turned.
constexpr double kIsotropic = 1e-6;

constexpr const char* kAtDirections = "at single directions: averaged over no solid angle";

/// What every header says: model, material, unit, solid angle, wavelengths, version, source.
std::vector<std::string> description(const BrdfReport& report, const std::string& command,
                                     const std::string& solid_angle = kAtDirections) {
  const Origin origin = origin_of(command);
  std::ostringstream wavelengths;
  wavelengths << "wavelengths (um):";
  for (const double lambda : report.request.lambda_um)
    wavelengths << ' ' << lambda;
  return {"model: " + report.description,
          "material: " + report.material,
          "BRDF in 1/sr, without the cosine, " + solid_angle,
          wavelengths.str(),
          "microbrdf " + origin.version + ", " + origin.created,
          "command: " + origin.command};
}

std::string joined(const std::vector<std::string>& lines, const std::string& between) {
  std::string text;
  for (const std::string& line : lines)
    text += (text.empty() ? "" : between) + line;
  return text;
}

double anisotropy_of(const AnyBrdf& model, const BrdfReport& report) {
  const std::vector<double>& lambda = report.request.lambda_um;
  return anisotropy(model, lambda[lambda.size() / 2]);
}

std::string write_tensor(const std::filesystem::path& path, const AnyBrdf& model, const BrdfReport& report,
                         const std::string& command) {
  const bool isotropic = anisotropy_of(model, report) < kIsotropic;
  const MeasuredTables t = measured_tables(model, report.request.lambda_um,
                                           isotropic ? MeasuredGrid::isotropic() : MeasuredGrid());
  const MeasuredGrid& g = t.grid;
  std::vector<std::string> lines = description(report, command);
  lines.emplace_back(
      "angles in rad, wavelengths in nm; light to 88.2 degrees; spectra x ndf / (4 sigma) is the BRDF "
      "times the cosine of the other direction");
  const std::string text = joined(lines, "\n");
  const std::byte jacobian{1};
  const std::vector<Tensor> tensors = {
      byte_tensor("description", std::as_bytes(std::span(text))),
      byte_tensor("jacobian", {&jacobian, 1}),
      float_tensor("theta_i", {g.theta_i}, t.theta_i),
      float_tensor("phi_i", {g.phi_i}, t.phi_i),
      float_tensor("ndf", {g.ndf_phi, g.ndf_theta}, t.ndf),
      float_tensor("sigma", {g.sigma_phi, g.sigma_theta}, t.sigma),
      float_tensor("vndf", {g.phi_i, g.theta_i, g.vndf_phi, g.vndf_theta}, t.vndf),
      float_tensor("luminance", {g.phi_i, g.theta_i, g.samples, g.samples}, t.luminance),
      float_tensor("wavelengths", {t.wavelengths.size()}, t.wavelengths),
      float_tensor("spectra", {g.phi_i, g.theta_i, t.wavelengths.size(), g.samples, g.samples}, t.spectra)};
  write_tensor_file(path, tensors);
  std::ostringstream kept;
  kept << (isotropic ? "isotropic, " : "anisotropic, ") << g.phi_i << " x " << g.theta_i
       << " directions of light, " << g.samples << "^2 of the viewer";
  return kept.str();
}

/// Linear sRGB of f in MERL's bins, NaN below the horizon, as a mean over azimuths of the half vector.
std::vector<float> merl_colours(const AnyBrdf& model, const std::vector<double>& lambda_um, int azimuths) {
  const ColourWeights weights(lambda_um);
  HalfAngleGrid grid;
  const auto size = static_cast<std::size_t>(grid.size());
  std::vector<float> rgb(3 * size);
  for (int a = 0; a < azimuths; ++a) {
    grid.phi_h = 2 * std::numbers::pi * a / azimuths;
    const std::vector<float> f = half_angle_table(model, lambda_um, grid);
    std::vector<double> at(lambda_um.size());
    for (std::size_t k = 0; k < size; ++k) {
      for (std::size_t c = 0; c < at.size(); ++c)
        at[c] = static_cast<double>(f[c * size + k]);
      const Vec3 colour = linear_srgb(weights.xyz(at)).cwiseMax(0) / azimuths;
      for (std::size_t c = 0; c < 3; ++c)
        rgb[c * size + k] += static_cast<float>(colour[static_cast<Eigen::Index>(c)]);
    }
  }
  for (std::size_t k = 0; k < size; ++k) {
    const auto n = static_cast<std::int64_t>(k);
    const auto [wi, wo] =
        grid.directions(n / (grid.phi_d * grid.theta_d), n / grid.phi_d % grid.theta_d, n % grid.phi_d);
    if (wi.z() > 0 && wo.z() > 0) continue;
    for (std::size_t c = 0; c < 3; ++c)
      rgb[c * size + k] = std::numeric_limits<float>::quiet_NaN();
  }
  return rgb;
}

std::string write_merl_file(const std::filesystem::path& path, const AnyBrdf& model, const BrdfReport& report,
                            const std::string& command) {
  constexpr int kAzimuths = 8;
  const double off = anisotropy_of(model, report);
  const int azimuths = off < kIsotropic ? 1 : kAzimuths;
  write_merl(path, merl_colours(model, report.request.lambda_um, azimuths));
  // The format has no header: what it would say lies beside it.
  write_text_file(exchange_paths(path).back(),
                  joined(description(report, command), "\n") +
                      "\nlinear sRGB under D65 of these wavelengths; -1 below the horizon\n");
  std::ostringstream kept;
  kept << "linear sRGB, 90 x 90 x 180";
  if (azimuths > 1)
    kept << ", a mean over " << azimuths << " azimuths, between which the model differs by up to "
         << 100 * off << " %";
  return kept.str();
}

std::string write_astm(const std::filesystem::path& path, const BrdfReport& report,
                       const std::string& command) {
  if (report.slices.empty()) throw InputError("an ASTM file holds the slices of --wi: give one or more");
  std::ostringstream text;
  text.precision(9);
  text << "ASTM E1392-90\n";
  for (const std::string& line : description(report, command))
    text << "# " << line << '\n';
  std::size_t points = 0;
  for (const BrdfSlice& slice : report.slices)
    points += slice.theta_o.size();
  text << "# angles in degrees: theta from the normal, phi from +x towards +y, of the directions to light "
          "(i) and "
          "viewer (s)\nNUM_POINTS "
       << points << "\nVARS theta_i,phi_i,theta_s,phi_s";
  for (const double lambda : report.request.lambda_um)
    text << ",BRDF " << 1000 * lambda << " nm";
  text << '\n';
  constexpr double kDegrees = 180 / std::numbers::pi;
  for (const BrdfSlice& slice : report.slices) {
    for (std::size_t k = 0; k < slice.theta_o.size(); ++k) {
      // θ_o is positive where a mirror sends to.
      const double away = slice.theta_o[k] >= 0 ? std::numbers::pi : 0;
      const double phi_s = std::remainder(slice.phi_i + slice.plane + away, 2 * std::numbers::pi);
      text << std::acos(slice.wi.z()) * kDegrees << ',' << slice.phi_i * kDegrees << ','
           << std::abs(slice.theta_o[k]) * kDegrees << ',' << phi_s * kDegrees;
      for (const auto& f : slice.f)
        text << ',' << f[k];
      text << '\n';
    }
  }
  write_text_file(path, text.str());
  return std::to_string(points) + " directions";
}

std::string write_radiance(const std::filesystem::path& path, const AnyBrdf& model, const BrdfReport& report,
                           const std::string& command) {
  constexpr std::uint64_t kDraws = 1 << 16;
  const std::vector<double>& lambda_um = report.request.lambda_um;
  const ColourWeights colour(lambda_um);
  std::vector<double> weights;
  for (std::size_t c = 0; c < lambda_um.size(); ++c) {
    std::vector<double> alone(lambda_um.size());
    alone[c] = 1;
    weights.push_back(colour.xyz(alone).y());
  }
  const KlemsMatrix matrix = klems_matrix(model, lambda_um, weights, kDraws);
  const auto lines =
      description(report, command, "a mean over the projected solid angles of both Klems patches");
  write_klems_xml(path, {report.material, "microbrdf", joined(lines, "; ")}, matrix.f);
  std::ostringstream kept;
  kept << "145 x 145 patches, luminance under D65, standard error of a patch's albedo at most "
       << matrix.standard_error;
  return kept.str();
}

}  // namespace

BrdfFormat brdf_format_of(const std::filesystem::path& path) {
  const std::string suffix = path.extension().string();
  if (suffix == ".bsdf") return BrdfFormat::Tensor;
  if (suffix == ".binary") return BrdfFormat::Merl;
  if (suffix == ".astm") return BrdfFormat::Astm;
  if (suffix == ".xml") return BrdfFormat::Radiance;
  throw InputError(
      "'" + path.string() +
      "' has none of the suffixes .bsdf (RGL, Mitsuba, pbrt), .binary (MERL), .astm and .xml (Radiance)");
}

std::vector<std::filesystem::path> exchange_paths(const std::filesystem::path& path) {
  std::vector<std::filesystem::path> files = {path};
  if (brdf_format_of(path) == BrdfFormat::Merl) files.emplace_back(path.string() + ".txt");
  return files;
}

ExchangedBrdf write_exchanged_brdf(const std::filesystem::path& path, const AnyBrdf& model,
                                   const BrdfReport& report, const std::string& command) {
  switch (brdf_format_of(path)) {
    case BrdfFormat::Tensor:
      return {path, write_tensor(path, model, report, command)};
    case BrdfFormat::Merl:
      return {path, write_merl_file(path, model, report, command)};
    case BrdfFormat::Astm:
      return {path, write_astm(path, report, command)};
    case BrdfFormat::Radiance:
      break;
  }
  return {path, write_radiance(path, model, report, command)};
}

}  // namespace micro
