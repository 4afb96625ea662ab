#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "height/repair.h"
#include "pipelines/ndf_of_scans.h"
#include "tools/common_options.h"
#include "tools/kirchhoff_options.h"

namespace micro::tools {

/// What `run` and `ndf` take in common, as typed.
struct NdfOptions {
  std::vector<double> sigmas;  ///< µm
  int size = 1025;
  std::string extent;  ///< empty: the whole disk
  Level level = Level::Plane;
  bool reject_outliers = false;
  double outlier_threshold = OutlierRule{}.threshold;  ///< robust standard deviations
  bool fill_holes = false;
  bool mixed = false;
  std::string signature;
  KirchhoffOptions kirchhoff;
  std::vector<std::string> pitch;
};

void add_ndf_options(CLI::App& app, NdfOptions& options);

/// The request that the options and the method names (naive, filtered, kirchhoff) make.
/// Throws CLI::ValidationError or InputError, with a sentence, if they make none.
NdfRequest make_request(const NdfOptions& options, const std::vector<std::string>& methods);

/// Throws CLI::ValidationError, with a sentence, if an option was given that none of the methods uses.
void require_in_use(const CLI::App& app, const std::vector<std::string>& methods);

/// Draws progress on stderr: scans done, rate and time left. Draws nothing unless progress is shown.
std::function<void(const Progress&)> progress_line(const CommonOptions& options);

/// Says what became of the scans: failures on stderr, the closing lines on stdout (or the JSON summary).
/// Returns the exit code.
int conclude(const NdfResult& result, const ScanListing& listing, const CommonOptions& options,
             const std::filesystem::path& output);

}  // namespace micro::tools
