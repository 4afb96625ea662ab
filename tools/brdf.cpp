#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>

#include "io/atomic_file.h"
#include "pipelines/brdf_exchange.h"
#include "pipelines/brdf_report.h"
#include "tools/brdf_model_options.h"
#include "tools/commands.h"
#include "tools/common_options.h"
#include "tools/json_output.h"
#include "tools/scan_output.h"
#include "tools/spectrum_options.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

struct Options {
  CommonOptions common;
  BrdfModelOptions model;
  std::string output;
  std::vector<std::string> lambda, wi, planes, write;
  double azimuth = 0, phi_h = 0;
  BrdfRequest request;
  double tolerance = 1e-3;
  bool albedo = false, furnace = false, table = false, no_figure = false;
};

BrdfRequest request_of(const Options& options) {
  BrdfRequest request = options.request;
  if (!std::isfinite(options.tolerance)) throw CLI::ValidationError("--tol is no finite number");
  if (!options.lambda.empty()) {
    request.lambda_um.clear();
    for (const std::string& text : options.lambda)
      std::ranges::copy(parse_wavelengths(text), std::back_inserter(request.lambda_um));
    if (!std::ranges::is_sorted(request.lambda_um, std::less_equal{}))
      throw CLI::ValidationError("--lambda: wavelengths must ascend");
  }
  for (const std::string& text : options.wi) {
    const double theta = parse_angle(text);
    if (!(theta >= 0 && theta < 1.5707963))
      throw CLI::ValidationError("--wi: '" + text + "' is no angle from 0 to below 90 degrees");
    request.wi.emplace_back(std::sin(theta) * std::cos(options.azimuth),
                            std::sin(theta) * std::sin(options.azimuth), std::cos(theta));
  }
  request.azimuth = options.azimuth;
  if (!options.planes.empty()) request.planes.clear();
  for (const std::string& text : options.planes)
    request.planes.push_back(parse_angle(text));
  if (options.albedo) request.albedo = options.tolerance;
  request.spectrum_tolerance = options.tolerance;
  if (options.furnace) request.furnace = options.tolerance;
  if (options.table) {
    request.table = HalfAngleGrid{};
    request.table->phi_h = options.phi_h;
  }
  if (request.wi.empty() && !request.furnace && !request.table && options.write.empty())
    throw CLI::ValidationError("nothing was asked for: give --wi, --furnace, --table or --write");
  if (request.wi.empty() && (options.albedo || request.spectrum > 0 || !options.planes.empty()))
    throw CLI::ValidationError("--albedo, --spectrum and --plane need a --wi");
  return request;
}

/// How many of the furnace's albedos have a larger error than was asked for.
std::ptrdiff_t not_reached(const BrdfReport& report) {
  return std::ranges::count_if(
      report.furnace->albedo, [&](const auto& albedo) { return !(albedo.error <= *report.request.furnace); });
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
                        {"reached", report.albedo[k][c].error <= *report.request.albedo},
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
    all["furnace_directions"] = report.furnace->albedo.size();
    all["furnace_not_reached"] = not_reached(report);
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
      std::printf("albedo at %.6g deg, %.4g um: %.5f +- %.1e%s\n",
                  std::acos(report.request.wi[k].z()) * 57.29577951308232, report.request.lambda_um[c],
                  report.albedo[k][c].value, report.albedo[k][c].error,
                  report.albedo[k][c].error <= *report.request.albedo ? "" : ", not the tolerance");
  if (report.spectrum)
    std::printf("linear sRGB (D65) %.4f %.4f %.4f\n", report.spectrum->linear_rgb.x(),
                report.spectrum->linear_rgb.y(), report.spectrum->linear_rgb.z());
  if (report.furnace) {
    std::printf("white furnace of a perfect mirror: at most %.5f; reciprocal to %.1e\n",
                report.furnace->most(), report.reciprocity->difference);
    if (const auto missed = not_reached(report); missed > 0)
      std::printf("%td of its %zu albedos did not reach the tolerance\n", missed,
                  report.furnace->albedo.size());
  }
  if (report.table) std::printf("table in %.2f s\n", report.table->cost.seconds);
  for (const auto& file : files)
    std::printf("%s\n", file.c_str());
  std::printf("%s\n", output.c_str());
}

/// Refuses outputs that cannot be written before anything is computed for them.
void require_outputs(const Options& options, const BrdfRequest& request) {
  std::vector<std::filesystem::path> files = {options.output}, inputs;
  for (const std::string& path : options.write) {
    if (brdf_format_of(path) == BrdfFormat::Astm && request.wi.empty())
      throw CLI::ValidationError("--write: an ASTM file holds the slices of --wi: give one or more");
    for (auto& file : exchange_paths(path))
      files.push_back(std::move(file));
  }
  if (!options.no_figure)
    for (auto& file : brdf_picture_paths(options.output, request))
      files.push_back(std::move(file));
  if (!options.model.input.empty()) inputs.emplace_back(options.model.input);
  require_writable(files, inputs);
}

int run(const Options& options, const CLI::App& app) {
  const BrdfRequest request = request_of(options);
  require_outputs(options, request);
  const BrdfModel model = make_brdf_model(options.model);
  const BrdfReport report = evaluate_brdf(model, options.model.material, request);
  write_brdf(options.output, report, command_line_of(app));
  auto files =
      options.no_figure ? std::vector<std::filesystem::path>() : write_brdf_pictures(options.output, report);
  std::vector<std::string> kept;
  for (const std::string& path : options.write) {
    const ExchangedBrdf written = write_exchanged_brdf(path, model.metal, report, command_line_of(app));
    files.push_back(written.path);
    kept.push_back(path + ": " + written.kept);
  }
  if (options.common.json) {
    nlohmann::json all = to_json(report, options.output, files);
    if (!kept.empty()) all["written"] = kept;
    print_json(all);
  } else {
    for (const std::string& line : kept)
      std::printf("%s\n", line.c_str());
    print(report, options.output, files);
  }
  return kDone;
}

}  // namespace

Run add_brdf(CLI::App& app) {
  auto options = std::make_shared<Options>();
  add_brdf_model_options(app, options->model);
  app.add_option("-o,--output", options->output, "HDF5 file to write; CSV and pictures go beside it")
      ->required();
  app.add_option("--lambda", options->lambda,
                 "Wavelength, or a range like 380nm..780nm/10nm (default 450nm 550nm 650nm); repeatable")
      ->type_name("LENGTH|RANGE")
      ->allow_extra_args(false);
  CLI::Option* wi =
      app.add_option("--wi", options->wi, "Polar angle of the light, for a slice in its plane; repeatable")
          ->type_name("ANGLE")
          ->allow_extra_args(false);
  add_angle(app, "--azimuth", options->azimuth, "Azimuth of the light and of its slices' planes (default 0)")
      ->needs(wi);
  app.add_option("--plane", options->planes,
                 "Azimuth of a slice from the plane of the light and the normal (default 0); repeatable")
      ->type_name("ANGLE")
      ->allow_extra_args(false);
  app.add_flag("--albedo", options->albedo, "Directional albedo at every --wi");
  app.add_option("--spectrum", options->request.spectrum,
                 "Albedo at the first --wi at this many wavelengths, and its colour")
      ->check(CLI::Range(1, 1000));
  app.add_flag("--furnace", options->furnace, "White furnace of a perfect mirror, and reciprocity");
  app.add_option("--tol", options->tolerance, "Absolute error of albedos")
      ->check(positive_number())
      ->capture_default_str();
  CLI::Option* table = app.add_flag(
      "--table", options->table, "The whole BRDF over 90 x 90 x 180 half and difference angles, as MERL's");
  add_angle(app, "--phi-h", options->phi_h, "Azimuth of the table's half vectors (default 0)")->needs(table);
  app.add_option(
         "--write", options->write,
         "Also write the BRDF for others: .bsdf (RGL's tensor file: Mitsuba 3, pbrt-v4), .binary (MERL), "
         ".astm (text, the slices) or .xml (Radiance, Klems basis); repeatable")
      ->type_name("FILE")
      ->allow_extra_args(false);
  app.add_flag("--no-figure", options->no_figure, "Leave out CSV and pictures");
  add_common_options(
      app, options->common,
      "microbrdf brdf out/result.h5 --material Cu --wi 30deg --albedo -o cu.h5\n"
      "  microbrdf brdf out/result.h5 --distribution kirchhoff --wi 30deg --plane 0 --plane 90deg "
      "-o wave.h5\n"
      "  microbrdf brdf out/result.h5 --material Cu --write copper.bsdf --write copper.xml -o cu.h5\n"
      "  microbrdf brdf --alpha 0.3,0.1 --coat 1.5 --material Cu --wi 45deg -o enamelled.h5\n"
      "  microbrdf brdf --model sun --smoothness 5 --form printed --wi 45deg --furnace -o sun.h5");
  return [options, &app] { return run(*options, app); };
}

}  // namespace micro::tools
