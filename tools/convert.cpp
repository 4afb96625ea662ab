#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "io/scan.h"
#include "tools/commands.h"
#include "tools/common_options.h"
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

int convert(const Options& options, const CLI::App& app) {
  const ReadOptions reading = parse_pitch(options.pitch);
  const ScanTarget& target = scan_target_of(options.output);
  std::error_code ignored;
  if (fs::equivalent(options.scan, options.output, ignored))
    throw FileError(options.output, "is the scan itself, which is never overwritten");
  Scan scan = read_scan(options.scan, reading);
  scan.surface = level(std::move(scan.surface), options.level);
  target.write(options.output, scan.surface, command_line_of(app));
  print_written(options.common, {{"source", scan.path.string()}, {"format", scan.format}},
                scan.path.string() + " (" + std::string(scan.format) + ")", options.output, target,
                scan.surface);
  return kDone;
}

}  // namespace

Run add_convert(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("scan", options->scan, "A scan in any readable format")->required()->type_name("SCAN");
  app.add_option("-o,--output", options->output,
                 std::string("File to write; its suffix ") + kScanSuffixes + " says the format")
      ->required()
      ->type_name("FILE");
  add_pitch(app, options->pitch,
            "Distance between points, P or X,Y, for formats that do not keep it (.npy, .exr, plain text)");
  add_level(app, options->level);
  add_common_options(app, options->common, "microbrdf convert scan.datx -o scan.dat");
  return [options, &app] { return convert(*options, app); };
}

}  // namespace micro::tools
