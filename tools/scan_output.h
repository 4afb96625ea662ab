#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "height/height_field.h"
#include "height/level.h"
#include "io/scan.h"
#include "tools/common_options.h"

namespace micro::tools {

/// A format in which surfaces are written.
struct ScanTarget {
  const char* suffix;
  const char* format;
  /// Writes whole or not at all; `command` is remembered by formats that have a place for it.
  void (*write)(const std::filesystem::path& path, const HeightField& surface, const std::string& command);
};

/// What the name of a written surface may end in, for people.
constexpr const char* kScanSuffixes = ".h5, .dat, .x3p, .npy or .exr";

/// The format to write, by the suffix of the output's name, the only thing that says it. Throws
/// CLI::ValidationError for other suffixes.
const ScanTarget& scan_target_of(const std::filesystem::path& output);

/// Says on stdout what was written: for people with `what` in front and what the format cannot keep, or as
/// JSON with the keys of `origin` and those of every surface.
void print_written(const CommonOptions& common, const nlohmann::json& origin, const std::string& what,
                   const std::filesystem::path& output, const ScanTarget& target, const HeightField& surface);

/// The command as it was given: the subcommands' names and every option that was set.
std::string command_line_of(const CLI::App& app);

/// --pitch P or X,Y.
CLI::Option* add_pitch(CLI::App& app, std::vector<std::string>& pitch, const std::string& help);
/// What --pitch says, µm. Throws CLI::ValidationError unless positive.
ReadOptions parse_pitch(const std::vector<std::string>& pitch);

/// --level none|mean|plane|quadratic; `target` holds the default.
CLI::Option* add_level(CLI::App& app, Level& target);

}  // namespace micro::tools
