#include "pipelines/study.h"

#include <cstdio>
#include <memory>

#include "io/atomic_file.h"
#include "pipelines/output_lock.h"
#include "pipelines/result_file.h"
#include "tools/commands.h"
#include "tools/json_output.h"
#include "tools/listing_output.h"
#include "tools/ndf_options.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

struct Options {
  CommonOptions common;
  NdfOptions ndf;
  std::vector<std::string> scans;
  std::string output;
};

/// Leaves study.csv, study.md and contact_sheet.png in the output folder and the table on stdout.
int conclude(const Study& study, const ScanListing& listing, const Options& options) {
  const nlohmann::json failed = report_failed(study.scans);
  for (const Stage& stage : study.left_out)
    std::fprintf(stderr, "microbrdf: %s: %s\n", stage.name.c_str(), stage.reason.c_str());
  if (options.common.json) {
    nlohmann::json summary = nlohmann::json::parse(to_json(study));
    summary["failed"] = failed;
    summary["skipped"] = skipped_json(listing);
    print_json(summary);
  }
  if (study.rows.empty()) {
    std::fprintf(stderr, "microbrdf: no scan gave the NDF '%s' to compare with\n", study.reference.c_str());
    return kNothing;
  }
  const std::filesystem::path output = options.output;
  const OutputLock lock(output);
  write_text_file(output / "study.csv", to_csv(study));
  write_text_file(output / "study.md", to_markdown(study));
  std::vector<NdfOfScans> ndfs;
  for (const StudyRow& row : study.rows)
    ndfs.push_back(row.ndf);
  write_png(output / "contact_sheet.png", comparison_sheet(ndfs));
  if (!options.common.json) {
    std::printf("%s\n", to_markdown(study).c_str());
    print_skipped(listing);
  }
  return failed.empty() ? kDone : kSomeFailed;
}

std::shared_ptr<Options> add_study_options(CLI::App& app, const char* example) {
  auto options = std::make_shared<Options>();
  options->ndf.size = 257;
  options->ndf.extent = "auto";
  app.add_option("SCAN", options->scans, "Scans, or directories of scans")->required();
  app.add_option("-o,--output", options->output, "Folder for study.csv, study.md and contact_sheet.png")
      ->required();
  add_ndf_options(app, options->ndf);
  add_progress(app, options->common);
  add_common_options(app, options->common, example);
  return options;
}

ScanListing listing_of(const Options& options) {
  ScanListing listing = list_scans({options.scans.begin(), options.scans.end()}, options.output);
  require_scans(listing, options.scans);
  return listing;
}

}  // namespace

Run add_study(CLI::App& app) {
  app.require_subcommand(1);
  CLI::App* sigma =
      app.add_subcommand("sigma", "Sensitivity of the filtered NDF to --sigma [Dong15 §5.1, Fig. 5]");
  const auto sigma_options =
      add_study_options(*sigma, "microbrdf study sigma scans/ -o study --sigma 0.5um --sigma 1um");
  CLI::App* filters =
      app.add_subcommand("filters", "Outlier rejection and hole filling, off and on [Dong15 §4.1]");
  const auto filter_options = add_study_options(*filters, "microbrdf study filters scans/ -o study");
  // What the study varies itself is not for the user to set.
  for (const char* name : {"--sigma", "--outlier-threshold", "--reject-outliers", "--fill-holes"})
    filters->remove_option(filters->get_option(name));
  // Both are about the filtered NDF.
  for (CLI::App* study : {sigma, filters})
    for (const char* name :
         {"--theta-d", "--lambda", "--lambda-q", "--tol", "--coherence", "--estimator", "--directions"})
      study->remove_option(study->get_option(name));
  CLI::App* waves = app.add_subcommand(
      "waves", "D_K against the filtered NDF on synthetic surfaces, measured and predicted [Dong15 §6.2]");
  const Run run_waves = add_wave_study(*waves);
  CLI::App* shadowing = app.add_subcommand(
      "shadowing", "Sun's free travel probability against simulation and Smith [Sun02 §3.4, §4]");
  const Run run_shadowing = add_shadowing_study(*shadowing);
  CLI::App* coat = app.add_subcommand(
      "coat", "Sun's BRDF and the coat in the white furnace, corrected and as printed [Sun02, SunGlossy]");
  const Run run_coat = add_coat_study(*coat);
  return [=] {
    if (waves->parsed()) return run_waves();
    if (shadowing->parsed()) return run_shadowing();
    if (coat->parsed()) return run_coat();
    const Options& options = filters->parsed() ? *filter_options : *sigma_options;
    const ScanListing listing = listing_of(options);
    const NdfRequest request = make_request(options.ndf, {});
    const auto progress = progress_line(options.common);
    if (filters->parsed()) return conclude(study_filters(listing, request, progress), listing, options);
    const std::vector<double>& asked = options.ndf.sigmas;
    const std::vector<double> sigmas =
        asked.empty() ? std::vector<double>{0.25, 0.5, 0.75, 1, 1.25, 1.5, 2} : asked;
    return conclude(study_sigma(listing, request, sigmas, progress), listing, options);
  };
}

}  // namespace micro::tools
