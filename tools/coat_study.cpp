#include "pipelines/coat_study.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "pipelines/output_lock.h"
#include "tools/commands.h"
#include "tools/common_options.h"
#include "tools/json_output.h"

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
  write_text_file(output / "furnace.csv", to_csv(rows));
  write_text_file(output / "furnace.md", to_markdown(rows));
  write_coat_figures(output);
  if (!options.common.json) {
    std::printf("%s", to_markdown(rows).c_str());
    return kDone;
  }
  nlohmann::json albedos = nlohmann::json::array();
  for (const FurnaceRow& row : rows)
    albedos.push_back({{"s", row.s},
                       {"theta_deg", row.theta_deg},
                       {"sun", row.sun.value},
                       {"sun_printed", row.sun_printed.value},
                       {"coat", row.coat.value},
                       {"coat_printed", row.coat_printed.value}});
  const nlohmann::json summary = {{"rows", albedos}};
  print_json(summary);
  return kDone;
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
