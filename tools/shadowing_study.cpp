#include "pipelines/shadowing_study.h"

#include <memory>

#include "pipelines/output_lock.h"
#include "tools/study_output.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

struct Options {
  CommonOptions common;
  ShadowingRequest study;
  std::string output;
};

int run(const Options& options) {
  const std::filesystem::path output = options.output;
  const OutputLock lock(output);
  ShadowingRequest request = options.study;
  request.nu = shadowing_study_slopes();
  const std::vector<ShadowingStudyRow> rows = study_shadowing(request);
  write_shadowing_figures(rows, output);
  nlohmann::json slopes = nlohmann::json::array();
  for (const ShadowingStudyRow& row : rows)
    slopes.push_back({{"nu", row.simulated.nu},
                      {"rays", row.simulated.rays},
                      {"sun_closed", row.sun_closed},
                      {"sun_mean_height", row.sun_mean_height},
                      {"sun_mean", row.sun_mean.value},
                      {"sun_product", row.sun_product.value},
                      {"smith_g1", 1 / (1 + row.smith_lambda)},
                      {"simulated_mean_height", row.simulated.from_mean_height().all.value},
                      {"simulated_mean_height_error", row.simulated.from_mean_height().all.error},
                      {"simulated_facing", row.simulated.from_anywhere.facing.value},
                      {"simulated_facing_error", row.simulated.from_anywhere.facing.error}});
  return conclude({output / "study", to_csv(rows), to_markdown(rows), slopes}, options.common);
}

}  // namespace

Run add_shadowing_study(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("-o,--output", options->output, "Folder for study.csv, study.md and the figures")
      ->required();
  app.add_option("--profiles", options->study.profiles, "Profiles to trace, 4096 correlation lengths each")
      ->check(CLI::Range(2, 1000000))
      ->capture_default_str();
  app.add_option("--seed", options->study.seed, "Seed of the profiles")
      ->check(seed_number())
      ->capture_default_str();
  add_common_options(app, options->common, "microbrdf study shadowing -o study");
  return [options] { return run(*options); };
}

}  // namespace micro::tools
