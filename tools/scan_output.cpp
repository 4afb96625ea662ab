#include "tools/scan_output.h"

#include <array>
#include <iomanip>
#include <iostream>
#include <sstream>

#include "io/exr.h"
#include "io/exr_heights.h"
#include "io/microbrdf_hdf5.h"
#include "io/npy.h"
#include "io/x3p.h"
#include "io/zygo_dat.h"
#include "pipelines/origin.h"
#include "tools/json_output.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::array kTargets = {
    ScanTarget{".h5", kMicrobrdfHdf5.name.data(),
               [](const fs::path& path, const HeightField& surface, const std::string& command) {
                 write_microbrdf_hdf5(path, surface, origin_of(command));
               }},
    ScanTarget{".dat", kZygoDat.name.data(),
               [](const fs::path& path, const HeightField& surface, const std::string&) {
                 write_zygo_dat(path, surface);
               }},
    ScanTarget{".x3p", kX3p.name.data(),
               [](const fs::path& path, const HeightField& surface, const std::string&) {
                 write_x3p(path, surface);
               }},
    ScanTarget{".npy", kNpy.name.data(),
               [](const fs::path& path, const HeightField& surface, const std::string&) {
                 write_npy(path, surface);
               }},
    ScanTarget{".exr", kExrHeights.name.data(),
               [](const fs::path& path, const HeightField& surface, const std::string& command) {
                 const Grid<float> z = (surface.z.cast<double>() + surface.mean).cast<float>();
                 write_exr(path, {{"Y", z}}, {{"unit", "um"}, {"command", command}});
               }}};

/// A sentence for people about what the format cannot keep (.npy, .exr: the pitch); empty if it keeps all.
std::string what_is_lost(const ScanTarget& target, const HeightField& surface) {
  if (target.format != kNpy.name && target.format != kExrHeights.name) return {};
  std::ostringstream text;
  text << std::setprecision(10) << "A " << target.suffix
       << " file has no place for the pitch: read it again with --pitch " << surface.dx << "um," << surface.dy
       << "um\n";
  return text.str();
}

}  // namespace

const ScanTarget& scan_target_of(const fs::path& output) {
  for (const ScanTarget& target : kTargets)
    if (output.extension() == target.suffix) return target;
  throw CLI::ValidationError("--output", "'" + output.string() + "' should end in " + kScanSuffixes);
}

void print_written(const CommonOptions& common, const nlohmann::json& origin, const std::string& what,
                   const fs::path& output, const ScanTarget& target, const HeightField& surface) {
  if (!common.json) {
    std::cout << what << ", " << surface.cols() << " × " << surface.rows() << " points, "
              << missing_count(surface) << " missing → " << output.string() << '\n'
              << what_is_lost(target, surface);
    return;
  }
  nlohmann::json summary = {{"output", output.string()},
                            {"output_format", target.format},
                            {"rows", surface.rows()},
                            {"cols", surface.cols()},
                            {"dx_um", surface.dx},
                            {"dy_um", surface.dy},
                            {"missing", missing_count(surface)}};
  summary.update(origin);
  print_json(summary);
}

std::string command_line_of(const CLI::App& app) {
  std::string command =
      app.get_parent() != nullptr ? command_line_of(*app.get_parent()) + " " + app.get_name() : "microbrdf";
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0) continue;
    const std::string name = option->get_positional() ? "" : " " + option->get_name();
    command += name;
    if (option->get_items_expected_max() == 0) continue;  // a flag
    // An option that takes one argument at a time has its name before each.
    const std::string again = option->get_allow_extra_args() ? "" : name;
    for (const std::string& value : option->results())
      command += (&value == &option->results().front() ? "" : again) + " " + value;
  }
  return command;
}

CLI::Option* add_pitch(CLI::App& app, std::vector<std::string>& pitch, const std::string& help) {
  // One word, X,Y too: what follows it is the next argument.
  return app
      .add_option_function<std::string>(
          "--pitch", [&pitch](const std::string& text) { pitch = CLI::detail::split(text, ','); }, help)
      ->type_name("LENGTH");
}

ReadOptions parse_pitch(const std::vector<std::string>& pitch) {
  if (pitch.size() > 2) throw CLI::ValidationError("--pitch", "is one length, or two: X,Y");
  ReadOptions options;
  if (!pitch.empty()) options.pitch_x = parse_length(pitch[0]);
  if (pitch.size() > 1) options.pitch_y = parse_length(pitch[1]);
  for (const auto& length : {options.pitch_x, options.pitch_y})
    if (length && !(*length > 0)) throw CLI::ValidationError("--pitch", "must be positive");
  return options;
}

CLI::Option* add_level(CLI::App& app, Level& target) {
  std::vector<std::string> names;
  for (const Level how : kLevels)
    names.emplace_back(name_of(how));
  return app
      .add_option_function<std::string>(
          "--level", [&target](const std::string& name) { target = *level_from_name(name); },
          "What to subtract first (default: " + std::string(name_of(target)) + ")")
      ->check(CLI::IsMember(names));
}

}  // namespace micro::tools
