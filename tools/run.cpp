#include <algorithm>
#include <memory>

#include "core/error.h"
#include "pipelines/fit_figure.h"
#include "pipelines/fits_of_result.h"
#include "pipelines/output_lock.h"
#include "pipelines/result_file.h"
#include "tools/commands.h"
#include "tools/course_options.h"
#include "tools/listing_output.h"
#include "tools/ndf_options.h"
#include "tools/scan_output.h"

namespace micro::tools {
namespace {

constexpr std::array kStages = {"naive", "filtered", "kirchhoff", "fit", "statistics", "pictures", "report"};

struct Options {
  CommonOptions common;
  NdfOptions ndf;
  CourseOptions course;
  std::string directory, output;
  std::vector<std::string> without;
};

/// What an earlier run left here would contradict this one's result.
void remove_outputs(const std::filesystem::path& output) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(output, ignored)) {
    const std::string name = entry.path().filename().string();
    if ((name.starts_with("ndf_") && name.ends_with(".exr")) ||
        (name.starts_with("fit_") && name.ends_with(".png")) || name == "contact_sheet.png" ||
        name == "report.md" || name == "result.h5")
      std::filesystem::remove(entry.path(), ignored);
  }
}

int run(const Options& options, const CLI::App& app) {
  const auto wants = [&](const char* stage) {
    return std::find(options.without.begin(), options.without.end(), stage) == options.without.end();
  };
  std::vector<std::string> methods;
  for (const char* method : {"naive", "filtered", "kirchhoff"})
    if (wants(method)) methods.emplace_back(method);
  if (methods.empty()) throw CLI::ValidationError("--without leaves nothing to do");
  require_in_use(app, methods);
  NdfRequest request = make_request(options.ndf, methods);
  if (!wants("statistics")) request.statistics = NdfRequest::Statistics::LeaveOut;
  constexpr int kThumbnails = 12;
  if (wants("pictures")) request.thumbnails = kThumbnails;

  const std::filesystem::path output = options.output;
  if (!std::filesystem::exists(options.directory)) throw FileError(options.directory, "does not exist");
  // Read first: an output folder is made only for work that there is.
  const ScanListing listing = list_scans({options.directory}, output);
  require_scans(listing, {options.directory});
  const OutputLock lock(output);
  const Course course = make_course(options.course, output / "checkpoint.h5");
  NdfResult result = ndf_of_scans(listing, request, progress_line(options.common), course);
  note_resumed(result);
  for (const std::string& stage : options.without)
    if (stage != "statistics") result.plan.push_back({Stage::Outcome::LeftOut, stage, "--without"});
  if (!result.empty() || result.shard) {
    remove_outputs(output);
    if (wants("fit")) {
      result.fits = fits_of(result);
      result.plan.push_back(stage_of(*result.fits));
    }
    if (wants("pictures")) {
      if (result.fits)
        for (const NdfTable& table : tables_of(result))
          write_fit_figure(output / fit_figure_name(table.method), table, *result.fits);
      for (const NdfOfScans& ndf : result.ndfs)
        write_ndf_picture(output / ("ndf_" + ndf.method.name + ".exr"), ndf);
      write_contact_sheet(output / "contact_sheet.png", result);
      result.plan.push_back(
          {Stage::Outcome::Ran, "pictures", "EXR of each NDF, contact_sheet.png, a figure of each fit"});
    }
    if (wants("report")) {
      result.plan.push_back({Stage::Outcome::Ran, "report", "report.md"});
      write_report(output / "report.md", result, listing, command_line_of(app));
    }
    write_result(output / "result.h5", result, command_line_of(app));
  }
  std::error_code ignored;
  std::filesystem::remove(course.checkpoint, ignored);
  return conclude(result, listing, options.common, output / "result.h5");
}

}  // namespace

Run add_run(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("DIR", options->directory, "Directory of scans, read recursively")->required();
  app.add_option("-o,--output", options->output, "Folder for result.h5, pictures and report.md")->required();
  app.add_option("--without", options->without,
                 "Stages to leave out: naive, filtered, kirchhoff, fit, statistics, pictures, report")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(std::vector<std::string>(kStages.begin(), kStages.end())));
  add_ndf_options(app, options->ndf);
  add_course_options(app, options->course);
  add_progress(app, options->common);
  add_common_options(app, options->common, "microbrdf run scans/ -o out --without naive");
  return [options, &app] { return run(*options, app); };
}

}  // namespace micro::tools
