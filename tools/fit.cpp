#include <cmath>
#include <memory>

#include "pipelines/fit_figure.h"
#include "pipelines/output_lock.h"
#include "tools/commands.h"
#include "tools/common_options.h"
#include "tools/json_output.h"
#include "tools/scan_output.h"

namespace micro::tools {
namespace {

namespace fs = std::filesystem;

struct Options {
  CommonOptions common;
  std::string input, output, weighting = "solid-angle";
  bool no_figure = false;
};

nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

nlohmann::json to_json(const NdfFit& ndf_fit) {
  const Fit& fit = ndf_fit.fit;
  const EllipsoidParameters& p = fit.parameters;
  nlohmann::json covariance = nlohmann::json::array();
  for (int a = 0; a < 5; ++a) {
    nlohmann::json row = nlohmann::json::array();
    for (int b = 0; b < 5; ++b)
      row.push_back(number(fit.covariance(a, b)));
    covariance.push_back(row);
  }
  return {{"method", ndf_fit.method},       {"model", name_of(fit.model)},
          {"alpha_x", number(p.alpha_x)},   {"alpha_y", number(p.alpha_y)},
          {"theta_x", number(p.theta_x)},   {"theta_y", number(p.theta_y)},
          {"theta_z", number(p.theta_z)},   {"covariance", covariance},
          {"rel_rms", number(fit.rel_rms)}, {"overlap", number(fit.overlap)},
          {"status", name_of(fit.status)},  {"undetermined", fit.undetermined},
          {"misfit", fit.misfit},           {"nodes_across", number(fit.nodes_across)},
          {"iterations", fit.iterations},   {"seconds", ndf_fit.seconds}};
}

void print(const NdfFits& fits, const CommonOptions& common, const fs::path& output,
           const std::vector<fs::path>& figures) {
  if (common.json) {
    nlohmann::json all = nlohmann::json::array(), left_out = nlohmann::json::array(),
                   pictures = nlohmann::json::array();
    for (const NdfFit& fit : fits.fits)
      all.push_back(to_json(fit));
    for (const NotFitted& table : fits.left_out)
      left_out.push_back({{"method", table.method}, {"message", table.reason}});
    for (const fs::path& figure : figures)
      pictures.push_back(figure.string());
    print_json(nlohmann::json{
        {"output", output.string()}, {"fits", all}, {"failed", left_out}, {"figures", pictures}});
    return;
  }
  for (const NdfFit& ndf_fit : fits.fits) {
    const Fit& fit = ndf_fit.fit;
    const EllipsoidParameters& p = fit.parameters;
    std::printf("%s %s: alpha %.4g, %.4g; theta %.4g, %.4g, %.4g rad; rel. rms %.3g; %s\n",
                ndf_fit.method.c_str(), std::string(name_of(fit.model)).c_str(), p.alpha_x, p.alpha_y,
                p.theta_x, p.theta_y, p.theta_z, fit.rel_rms, std::string(name_of(fit.status)).c_str());
    if (!fit.undetermined.empty()) std::printf("  not determined: %s\n", fit.undetermined.c_str());
    if (!fit.misfit.empty()) std::printf("  misfit: %s\n", fit.misfit.c_str());
  }
  for (const fs::path& figure : figures)
    std::printf("%s\n", figure.c_str());
  if (!fits.fits.empty()) std::printf("%s\n", output.c_str());
}

int run(const Options& options, const CLI::App& app) {
  const fs::path input = options.input, output = options.output.empty() ? input : fs::path(options.output);
  NdfTables tables = read_ndf_tables(input);
  const OutputLock lock = OutputLock::of_file(output);
  NdfFits fits = fit_ndfs(tables.tables, options.weighting == "log" ? Weighting::Log : Weighting::SolidAngle);
  fits.left_out.insert(fits.left_out.begin(), tables.left_out.begin(), tables.left_out.end());
  for (const NotFitted& table : fits.left_out)
    std::fprintf(stderr, "microbrdf: %s: %s: %s\n", input.c_str(), table.method.c_str(),
                 table.reason.c_str());
  add_fits(input, output, fits, command_line_of(app));
  std::vector<fs::path> figures;
  if (!options.no_figure)
    for (const NdfTable& table : tables.tables) {
      if (table.lambda_q) continue;  // a picture for each of many wavelengths is more than anyone looks at
      const fs::path figure =
          output.parent_path() / (output.stem().string() + "_" + fit_figure_name(table.method));
      if (write_fit_figure(figure, table, fits)) figures.push_back(figure);
    }
  print(fits, options.common, output, figures);
  if (fits.fits.empty()) return kNothing;
  return fits.left_out.empty() ? kDone : kSomeFailed;
}

}  // namespace

Run add_fit(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("FILE", options->input,
                 "HDF5 file with /ndf/<method>/density and its attribute extent: result.h5, or any other")
      ->required();
  app.add_option("-o,--output", options->output,
                 "HDF5 file to write (default: FILE itself, replaced when done)");
  app.add_option("--weighting", options->weighting,
                 "What is minimised: squared differences over solid-angle, or of the log, for the tails")
      ->check(CLI::IsMember({"solid-angle", "log"}))
      ->capture_default_str();
  app.add_flag("--no-figure", options->no_figure,
               "Leave out the figures, <output>_fit_<method>.png (none for a spectrum)");
  add_common_options(app, options->common, "microbrdf fit out/result.h5 --weighting log -o tails.h5");
  return [options, &app] { return run(*options, app); };
}

}  // namespace micro::tools
