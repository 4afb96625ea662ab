#include <cmath>
#include <memory>

#include "core/error.h"
#include "pipelines/brdf_report.h"
#include "tools/commands.h"
#include "tools/common_options.h"
#include "tools/json_output.h"
#include "tools/scan_output.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

struct Options {
  CommonOptions common;
  std::string input, output, distribution, fitted = "filtered", material = "mirror", masking = "smith";
  std::vector<std::string> alpha, theta, lambda, wi;
  double azimuth = 0, phi_h = 0;
  BrdfRequest request;
  double tolerance = 1e-3;
  bool albedo = false, furnace = false, table = false, no_figure = false;
};

/// Two lengths of the lobe, or one for both.
EllipsoidParameters lobe_of(const Options& options) {
  const auto number = [](const std::string& text) {
    try {
      std::size_t end = 0;
      const double value = std::stod(text, &end);
      if (end == text.size()) return value;
    } catch (const std::exception&) {
      // falls through to the sentence below
    }
    throw CLI::ValidationError("--alpha: '" + text + "' is no number");
  };
  if (options.alpha.empty()) throw CLI::ValidationError("a model without a FILE needs --alpha");
  const double alpha_x = number(options.alpha.front()), alpha_y = number(options.alpha.back());
  EllipsoidParameters parameters{alpha_x, alpha_y};
  double* const angles[] = {&parameters.theta_x, &parameters.theta_y, &parameters.theta_z};
  for (std::size_t k = 0; k < options.theta.size(); ++k)
    *angles[k] = parse_angle(options.theta[k]);
  return parameters;
}

BrdfModel model_of(const Options& options, const Fresnel& fresnel) {
  const std::string& distribution = options.distribution;
  if (options.input.empty())
    return lobe_model(distribution.empty() ? "ellipsoid" : distribution, lobe_of(options), fresnel);
  if (!options.alpha.empty() || !options.theta.empty())
    throw CLI::ValidationError("--alpha and --theta make a model; they do not go with a FILE");
  return result_model({options.input, distribution.empty() ? "filtered" : distribution, options.fitted,
                       options.masking == "none" ? Masking::None : Masking::Smith},
                      fresnel);
}

BrdfRequest request_of(const Options& options) {
  BrdfRequest request = options.request;
  if (!options.lambda.empty()) {
    request.lambda_um.clear();
    for (const std::string& text : options.lambda)
      request.lambda_um.push_back(parse_length(text));
  }
  for (const std::string& text : options.wi) {
    const double theta = parse_angle(text);
    if (!(theta >= 0 && theta < 1.5707963))
      throw CLI::ValidationError("--wi: '" + text + "' is no angle from 0 to below 90 degrees");
    request.wi.emplace_back(std::sin(theta) * std::cos(options.azimuth),
                            std::sin(theta) * std::sin(options.azimuth), std::cos(theta));
  }
  if (options.albedo) request.albedo = options.tolerance;
  if (options.furnace) request.furnace = options.tolerance;
  if (options.table) {
    request.table = HalfAngleGrid{};
    request.table->phi_h = options.phi_h;
  }
  if (request.wi.empty() && !request.furnace && !request.table)
    throw CLI::ValidationError("nothing was asked for: give --wi, --furnace or --table");
  if (request.wi.empty() && (options.albedo || request.spectrum > 0))
    throw CLI::ValidationError("--albedo and --spectrum need a --wi");
  return request;
}

nlohmann::json to_json(const BrdfReport& report, const std::string& output,
                       const std::vector<std::filesystem::path>& files) {
  nlohmann::json albedo = nlohmann::json::array(), names = nlohmann::json::array();
  for (std::size_t k = 0; k < report.albedo.size(); ++k)
    for (std::size_t c = 0; c < report.albedo[k].size(); ++c)
      albedo.push_back({{"theta_i", std::acos(report.request.wi[k].z())},
                        {"lambda_um", report.request.lambda_um[c]},
                        {"value", report.albedo[k][c].value},
                        {"error", report.albedo[k][c].error},
                        {"draws", report.albedo[k][c].cost.evaluations}});
  for (const auto& file : files)
    names.push_back(file.string());
  nlohmann::json all = {{"output", output},
                        {"model", report.description},
                        {"material", report.material},
                        {"albedo", albedo},
                        {"files", names}};
  if (report.spectrum) {
    const auto list = [](const Vec3& v) { return nlohmann::json{v.x(), v.y(), v.z()}; };
    all["xyz"] = list(report.spectrum->xyz);
    all["linear_srgb"] = list(report.spectrum->linear_rgb);
  }
  if (report.furnace) {
    all["furnace_most"] = report.furnace->most();
    all["reciprocity"] = report.reciprocity->difference;
  }
  if (report.table) all["table_seconds"] = report.table->cost.seconds;
  return all;
}

void print(const BrdfReport& report, const std::string& output,
           const std::vector<std::filesystem::path>& files) {
  std::printf("%s; %s\n", report.description.c_str(), report.material.c_str());
  for (std::size_t k = 0; k < report.albedo.size(); ++k)
    for (std::size_t c = 0; c < report.albedo[k].size(); ++c)
      std::printf("albedo at %.4g deg, %.4g um: %.5f +- %.1e\n",
                  std::acos(report.request.wi[k].z()) * 57.29577951308232, report.request.lambda_um[c],
                  report.albedo[k][c].value, report.albedo[k][c].error);
  if (report.spectrum)
    std::printf("linear sRGB (D65) %.4f %.4f %.4f\n", report.spectrum->linear_rgb.x(),
                report.spectrum->linear_rgb.y(), report.spectrum->linear_rgb.z());
  if (report.furnace)
    std::printf("white furnace of a perfect mirror: at most %.5f; reciprocal to %.1e\n",
                report.furnace->most(), report.reciprocity->difference);
  if (report.table) std::printf("table in %.2f s\n", report.table->cost.seconds);
  for (const auto& file : files)
    std::printf("%s\n", file.c_str());
  std::printf("%s\n", output.c_str());
}

int run(const Options& options, const CLI::App& app) {
  const BrdfRequest request = request_of(options);
  const BrdfModel model = model_of(options, material(options.material));
  const BrdfReport report = evaluate_brdf(model, options.material, request);
  write_brdf(options.output, report, command_line_of(app));
  const auto files =
      options.no_figure ? std::vector<std::filesystem::path>() : write_brdf_pictures(options.output, report);
  if (options.common.json)
    print_json(to_json(report, options.output, files));
  else
    print(report, options.output, files);
  return kDone;
}

}  // namespace

Run add_brdf(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option(
      "FILE", options->input,
      "HDF5 file with /ndf/<method>/density: result.h5, or any other (without: a model by --alpha)");
  app.add_option("-o,--output", options->output, "HDF5 file to write; CSV and pictures go beside it")
      ->required();
  app.add_option(
      "--distribution", options->distribution,
      "Of FILE: filtered (default), naive, kirchhoff, kirchhoff_spectrum or any other method in it, or "
      "ellipsoid or beckmann as fitted; without FILE: ellipsoid (default) or beckmann");
  app.add_option("--fit-of", options->fitted, "The method whose fit ellipsoid and beckmann are")
      ->capture_default_str();
  app.add_option("--alpha", options->alpha, "Width of the model's lobe, or X,Y")
      ->delimiter(',')
      ->expected(1, 2);
  app.add_option("--theta", options->theta, "The lobe's angles X,Y,Z [Dong15 Eq. 12]")
      ->delimiter(',')
      ->expected(1, 3);
  app.add_option("--material", options->material,
                 "Al, Cu, Au, Ag, Fe, Cr, Ni, Ti, steel, mirror, or an index: 1.5 or 0.2,3.4")
      ->capture_default_str();
  app.add_option("--masking", options->masking, "G of Kirchhoff models: smith or none")
      ->check(CLI::IsMember({"smith", "none"}))
      ->capture_default_str();
  app.add_option("--lambda", options->lambda, "Wavelength (default 450nm 550nm 650nm); repeatable")
      ->type_name("LENGTH")
      ->allow_extra_args(false);
  app.add_option("--wi", options->wi, "Polar angle of the light, for a slice in its plane; repeatable")
      ->type_name("ANGLE")
      ->allow_extra_args(false);
  add_angle(app, "--azimuth", options->azimuth, "Azimuth of the light (default 0)");
  app.add_flag("--albedo", options->albedo, "Directional albedo at every --wi");
  app.add_option("--spectrum", options->request.spectrum,
                 "Albedo at the first --wi at this many wavelengths, and its colour")
      ->check(CLI::Range(1, 1000));
  app.add_flag("--furnace", options->furnace, "White furnace of a perfect mirror, and reciprocity");
  app.add_option("--tol", options->tolerance, "Absolute error of albedos")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--table", options->table,
               "The whole BRDF over 90 x 90 x 180 half and difference angles, as MERL's");
  add_angle(app, "--phi-h", options->phi_h, "Azimuth of the table's half vectors (default 0)");
  app.add_flag("--no-figure", options->no_figure, "Leave out CSV and pictures");
  add_common_options(app, options->common,
                     "microbrdf brdf out/result.h5 --material Cu --wi 30deg --albedo -o cu.h5");
  return [options, &app] { return run(*options, app); };
}

}  // namespace micro::tools
