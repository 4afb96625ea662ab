#include <array>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "io/microbrdf_hdf5.h"
#include "io/npy.h"
#include "io/scan.h"
#include "io/zygo_dat.h"
#include "pipelines/version.h"
#include "tools/commands.h"
#include "tools/common_options.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

namespace fs = std::filesystem;

struct Options {
  CommonOptions common;
  fs::path scan;
  fs::path output;
  std::vector<std::string> pitch;
};

/// The command as it was given.
std::string command_of(const Options& options) {
  std::string command = "microbrdf convert " + options.scan.string() + " -o " + options.output.string();
  for (std::size_t k = 0; k < options.pitch.size(); ++k)
    command += (k == 0 ? " --pitch " : ",") + options.pitch[k];
  return command;
}

std::string now_utc() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, sizeof "2000-01-01T00:00:00Z"> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

using Write = void (*)(const Options& options, const HeightField& surface);

/// A format that can be written.
struct Target {
  const char* suffix;
  const char* format;
  Write write;
};

constexpr std::array kTargets = {
    Target{".h5", "microbrdf-hdf5",
           [](const Options& options, const HeightField& surface) {
             write_microbrdf_hdf5(
                 options.output, surface,
                 {.version = std::string(version()), .created = now_utc(), .command = command_of(options)});
           }},
    Target{
        ".dat", "zygo-dat",
        [](const Options& options, const HeightField& surface) { write_zygo_dat(options.output, surface); }},
    Target{".npy", "npy",
           [](const Options& options, const HeightField& surface) { write_npy(options.output, surface); }}};

/// The format to write, by the suffix of the output's name, the only thing that says it.
const Target& target_of(const fs::path& output) {
  for (const Target& target : kTargets)
    if (output.extension() == target.suffix) return target;
  throw CLI::ValidationError("--output", "'" + output.string() + "' should end in .h5, .dat or .npy");
}

ReadOptions read_options(const std::vector<std::string>& pitch) {
  ReadOptions options;
  if (!pitch.empty()) options.pitch_x = parse_length(pitch[0]);
  if (pitch.size() > 1) options.pitch_y = parse_length(pitch[1]);
  for (const auto& length : {options.pitch_x, options.pitch_y})
    if (length && !(*length > 0)) throw CLI::ValidationError("--pitch", "must be positive");
  return options;
}

void print_summary(const Options& options, const Scan& scan, const Target& target) {
  const HeightField& surface = scan.surface;
  if (options.common.json) {
    std::cout << nlohmann::json{{"source", scan.path.string()},
                                {"format", scan.format},
                                {"output", options.output.string()},
                                {"output_format", target.format},
                                {"rows", surface.rows()},
                                {"cols", surface.cols()},
                                {"dx_um", surface.dx},
                                {"dy_um", surface.dy},
                                {"missing", missing_count(surface)}}
                     .dump()
              << '\n';
    return;
  }
  std::cout << scan.path.string() << " (" << scan.format << ", " << surface.cols() << " × " << surface.rows()
            << " points, " << missing_count(surface) << " missing) → " << options.output.string() << '\n';
  if (target.format == kNpy.name)
    std::cout << std::setprecision(10)
              << "A .npy file has no place for the pitch: read it again with --pitch " << surface.dx << "um,"
              << surface.dy << "um\n";
}

int convert(const Options& options) {
  const ReadOptions reading = read_options(options.pitch);
  const Target& target = target_of(options.output);
  std::error_code ignored;
  if (fs::equivalent(options.scan, options.output, ignored))
    throw FileError(options.output, "is the scan itself, which is never overwritten");
  const Scan scan = read_scan(options.scan, reading);
  target.write(options, scan.surface);
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
  app.add_option("--pitch", options->pitch,
                 "Distance between points, P or X,Y, for formats that do not keep it (.npy, plain text)")
      ->delimiter(',')
      ->expected(1, 2)
      ->type_name("LENGTH");
  add_common_options(app, options->common, "microbrdf convert scan.datx -o scan.dat");
  return [options] { return convert(*options); };
}

}  // namespace micro::tools
