#include "pipelines/coat_study.h"

#include <memory>

#include "pipelines/output_lock.h"
#include "tools/study_output.h"

namespace micro::tools {
namespace {

struct Options {
  CommonOptions common;
  double tolerance = 2e-3;
  std::string output;
};

int run(const Options& options) {
  const std::filesystem::path output = options.output;
  const OutputLock lock(output);
  const std::vector<FurnaceRow> rows = study_coat_furnace(options.tolerance);
  write_coat_figures(output);
  nlohmann::json albedos = nlohmann::json::array();
  for (const FurnaceRow& row : rows)
    albedos.push_back({{"s", row.s},
                       {"theta_deg", row.theta_deg},
                       {"sun", row.sun.value},
                       {"sun_printed", row.sun_printed.value},
                       {"coat", row.coat.value},
                       {"coat_printed", row.coat_printed.value}});
  return conclude({output / "furnace", to_csv(rows), to_markdown(rows), albedos}, options.common);
}

}  // namespace

Run add_coat_study(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("-o,--output", options->output, "Folder for furnace.csv, furnace.md and the figures")
      ->required();
  app.add_option("--tol", options->tolerance, "Absolute error of an albedo")
      ->check(CLI::Range(1e-5, 0.1))
      ->capture_default_str();
  add_common_options(app, options->common, "microbrdf study coat -o study");
  return [options] { return run(*options); };
}

}  // namespace micro::tools
