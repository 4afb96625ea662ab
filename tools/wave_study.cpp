#include "pipelines/wave_study.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "pipelines/output_lock.h"
#include "tools/commands.h"
#include "tools/common_options.h"
#include "tools/json_output.h"
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
  write_text_file(output / "study.csv", to_csv(rows));
  write_text_file(output / "study.md", to_markdown(rows));
  if (!options.common.json) {
    std::printf("%s", to_markdown(rows).c_str());
    return kDone;
  }
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
  const nlohmann::json summary = {{"rows", surfaces}};
  print_json(summary);
  return kDone;
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
