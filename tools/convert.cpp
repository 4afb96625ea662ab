#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "io/scan.h"
#include "tools/commands.h"
#include "tools/common_options.h"
#include "tools/json_output.h"
#include "tools/scan_output.h"

namespace micro::tools {
namespace {

namespace fs = std::filesystem;

struct Options {
  CommonOptions common;
  fs::path scan;
  fs::path output;
  std::vector<std::string> pitch;
  Level level = Level::None;
};

void print_summary(const Options& options, const Scan& scan, const ScanTarget& target) {
  const HeightField& surface = scan.surface;
  if (options.common.json) {
    print_json(nlohmann::json{{"source", scan.path.string()},
                              {"format", scan.format},
                              {"output", options.output.string()},
                              {"output_format", target.format},
                              {"rows", surface.rows()},
                              {"cols", surface.cols()},
                              {"dx_um", surface.dx},
                              {"dy_um", surface.dy},
                              {"missing", missing_count(surface)}});
    return;
  }
  std::cout << scan.path.string() << " (" << scan.format << ", " << surface.cols() << " × " << surface.rows()
            << " points, " << missing_count(surface) << " missing) → " << options.output.string() << '\n';
  std::cout << what_is_lost(target, surface);
}

int convert(const Options& options, const CLI::App& app) {
  const ReadOptions reading = parse_pitch(options.pitch);
  const ScanTarget& target = scan_target_of(options.output);
  std::error_code ignored;
  if (fs::equivalent(options.scan, options.output, ignored))
    throw FileError(options.output, "is the scan itself, which is never overwritten");
  Scan scan = read_scan(options.scan, reading);
  scan.surface = level(std::move(scan.surface), options.level);
  target.write(options.output, scan.surface, command_line_of(app));
  print_summary(options, scan, target);
  return kDone;
}

}  // namespace

Run add_convert(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("scan", options->scan, "A scan in any readable format")->required()->type_name("SCAN");
  app.add_option("-o,--output", options->output,
                 "File to write; its suffix .h5, .dat or .npy says the format")
      ->required()
      ->type_name("FILE");
  add_pitch(app, options->pitch,
            "Distance between points, P or X,Y, for formats that do not keep it (.npy, plain text)");
  add_level(app, options->level);
  add_common_options(app, options->common, "microbrdf convert scan.datx -o scan.dat");
  return [options, &app] { return convert(*options, app); };
}

}  // namespace micro::tools
