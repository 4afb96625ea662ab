#include "pipelines/wave_study.h"

#include <memory>

#include "pipelines/output_lock.h"
#include "tools/study_output.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

struct Options {
  CommonOptions common;
  WaveStudyRequest study;
  std::string output;
};

int run(const Options& options) {
  if (!(options.study.lambda_q > 0)) throw CLI::ValidationError("--lambda-q: a wavelength must be positive");
  if (!(options.study.sigma > 0))
    throw CLI::ValidationError("--sigma: the window must be wider than nothing");
  const std::filesystem::path output = options.output;
  const OutputLock lock(output);
  std::vector<WaveStudyRow> rows;
  for (const WaveStudyCase& surface : wave_study_cases())
    rows.push_back(study_waves(surface, options.study));
  nlohmann::json surfaces = nlohmann::json::array();
  for (const WaveStudyRow& row : rows)
    surfaces.push_back({{"surface", row.name},
                        {"lambda_q_um", row.lambda_q},
                        {"alpha_kirchhoff", row.kirchhoff.value},
                        {"alpha_kirchhoff_error", row.kirchhoff.error},
                        {"alpha_kirchhoff_predicted", row.kirchhoff_predicted},
                        {"alpha_filtered", row.filtered.value},
                        {"alpha_filtered_error", row.filtered.error},
                        {"alpha_filtered_predicted", row.filtered_predicted}});
  return conclude({output / "study", to_csv(rows), to_markdown(rows), surfaces}, options.common);
}

}  // namespace

Run add_wave_study(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("-o,--output", options->output, "Folder for study.csv and study.md")->required();
  app.add_option("--surfaces", options->study.surfaces, "Synthetic surfaces of each kind")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  add_length(app, "--lambda-q", options->study.lambda_q, "Effective wavelength of D_K (default 555nm)");
  add_length(app, "--sigma", options->study.sigma, "Window of the filtered NDF (default 1um)");
  add_common_options(app, options->common, "microbrdf study waves -o study");
  return [options] { return run(*options); };
}

}  // namespace micro::tools
