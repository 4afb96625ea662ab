#include <memory>

#include "pipelines/output_lock.h"
#include "pipelines/result_file.h"
#include "tools/commands.h"
#include "tools/course_options.h"
#include "tools/listing_output.h"
#include "tools/ndf_options.h"
#include "tools/scan_output.h"

namespace micro::tools {
namespace {

struct Options {
  CommonOptions common;
  NdfOptions ndf;
  CourseOptions course;
  std::vector<std::string> scans;
  std::string output;
  std::vector<std::string> methods = {"filtered"};
};

int run(const Options& options, const CLI::App& app) {
  require_in_use(app, options.methods);
  NdfRequest request = make_request(options.ndf, options.methods);
  request.unfit = NdfRequest::Unfit::Fail;  // what was asked for by name is done or refused
  const ScanListing listing = list_scans({options.scans.begin(), options.scans.end()}, options.output);
  require_scans(listing, options.scans);
  const OutputLock lock = OutputLock::of_file(options.output);
  const Course course = make_course(options.course, options.output + ".checkpoint");
  const NdfResult result = ndf_of_scans(listing, request, progress_line(options.common), course);
  note_resumed(result);
  if (!result.empty() || result.shard) write_result(options.output, result, command_line_of(app));
  std::error_code ignored;
  std::filesystem::remove(course.checkpoint, ignored);
  return conclude(result, listing, options.common, options.output);
}

}  // namespace

Run add_ndf(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("SCAN", options->scans, "Scans, or directories of scans")->required();
  app.add_option("-o,--output", options->output, "HDF5 file to write")->required();
  app.add_option("--method", options->methods, "naive, filtered or kirchhoff; repeatable")
      ->check(CLI::IsMember({"naive", "filtered", "kirchhoff"}))
      ->allow_extra_args(false)
      ->capture_default_str();
  add_ndf_options(app, options->ndf);
  add_course_options(app, options->course);
  add_progress(app, options->common);
  add_common_options(
      app, options->common,
      "microbrdf ndf scans/ -o brushed.h5 --method naive --method filtered --sigma 1um --signature 1.5deg");
  return [options, &app] { return run(*options, app); };
}

}  // namespace micro::tools
