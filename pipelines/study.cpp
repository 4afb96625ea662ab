#include "pipelines/study.h"

#include <algorithm>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "core/error.h"
#include "distribution/compare.h"
#include "height/repair.h"

namespace micro {
namespace {

/// Rejection threshold of the filters' study, in robust standard deviations.
const double kThreshold = OutlierRule{}.threshold;

/// Full width at half maximum of the paper's gonioreflectometer, radians [Dong15 §7].
constexpr double kSignature = 1.5 * std::numbers::pi / 180;

/// All of a study's tables stand on one grid: the widest that any of them needs.
NdfRequest on_common_grid(const ScanListing& listing, NdfRequest request,
                          const std::function<void(const Progress&)>& report) {
  if (!std::holds_alternative<HoldsEnergy>(request.extent)) return request;
  double extent = 0;
  for (const NdfOfScans& ndf : ndf_of_scans(listing, request, report).ndfs)
    extent = std::max(extent, ndf.density.grid.extent);
  request.extent = extent > 0 ? extent : 1.;
  return request;
}

StudyRow row_of(NdfOfScans ndf) {
  StudyRow row;
  const LobeWidth width = lobe_width(ndf.density);
  row.width_x = width.x;
  row.width_y = width.y;
  row.ndf = std::move(ndf);
  return row;
}

/// Holds every row against the row named `reference`; without one there is nothing to hold.
void compare(Study& study) {
  const auto reference = std::find_if(study.rows.begin(), study.rows.end(), [&](const StudyRow& row) {
    return row.ndf.method.name == study.reference;
  });
  if (reference == study.rows.end()) {
    study.rows.clear();
    return;
  }
  // Seen as the paper's gonioreflectometer would [§7]: bins of a few normals differ by chance alone.
  const Signature signature = gaussian_signature(kSignature);
  const DiskTable seen = convolve(reference->ndf.density, signature);
  for (StudyRow& row : study.rows)
    row.difference = total_variation(convolve(row.ndf.density, signature), seen);
}

}  // namespace

Study study_sigma(const ScanListing& listing, const NdfRequest& request, const std::vector<double>& sigmas,
                  const std::function<void(const Progress&)>& report) {
  // The paper's window, or the first where it is not among those asked for.
  const bool has_default = std::find(sigmas.begin(), sigmas.end(), 1.) != sigmas.end();
  Study study{.title = "Sensitivity to the window's sigma",
              .reference = filtered_name(has_default ? 1. : sigmas.front()),
              .rows = {},
              .scans = {},
              .left_out = {}};
  NdfRequest all = request;
  all.methods = {{"naive", Naive{}}};
  for (const double sigma : sigmas)
    all.methods.push_back({filtered_name(sigma), Filtered{sigma}});
  NdfResult result = ndf_of_scans(listing, on_common_grid(listing, all, report), report);
  for (NdfOfScans& ndf : result.ndfs)
    study.rows.push_back(row_of(std::move(ndf)));
  study.scans = std::move(result.scans);
  for (const Stage& stage : result.plan)
    if (stage.outcome == Stage::Outcome::LeftOut && stage.name.ends_with(" NDF"))
      study.left_out.push_back(stage);
  compare(study);
  return study;
}

Study study_filters(const ScanListing& listing, const NdfRequest& request,
                    const std::function<void(const Progress&)>& report) {
  Study study{.title = "Outlier rejection and hole filling",
              .reference = "filtered, as measured",
              .rows = {},
              .scans = {},
              .left_out = {}};
  NdfRequest plain = request;
  plain.methods = {{"filtered", Filtered{}}};
  plain = on_common_grid(listing, plain, report);
  struct Filters {
    const char* name;
    std::optional<double> threshold;
    Preparation::Holes holes;
  };
  using enum Preparation::Holes;
  for (const auto& [name, threshold, holes] :
       {Filters{"as measured", {}, Keep}, Filters{"outliers rejected", kThreshold, Keep},
        Filters{"holes filled", {}, Fill}, Filters{"outliers rejected, holes filled", kThreshold, Fill}}) {
    NdfRequest filtered = plain;
    filtered.prepare.outlier_threshold = threshold;
    filtered.prepare.holes = holes;
    NdfResult result = ndf_of_scans(listing, filtered, report);
    for (NdfOfScans& ndf : result.ndfs) {
      ndf.method.name += std::string(", ") + name;
      StudyRow row = row_of(std::move(ndf));
      for (const ScanRecord& scan : result.scans) {
        row.rejected += scan.rejected;
        row.filled += scan.filled;
      }
      study.rows.push_back(std::move(row));
    }
    study.scans = std::move(result.scans);
  }
  compare(study);
  return study;
}

std::string to_markdown(const Study& study) {
  std::ostringstream text;
  text << "### " << study.title << "\n\n"
       << "| NDF | scans | half interquartile range of m_x | of m_y | mass elsewhere than in '"
       << study.reference
       << "', at 1.5° resolution | points rejected | points filled | seconds "
          "|\n|---|---|---|---|---|---|---|---|\n"
       << std::setprecision(4);
  for (const StudyRow& row : study.rows)
    text << "| " << row.ndf.method.name << " | " << row.ndf.scans << " | " << row.width_x << " | "
         << row.width_y << " | " << 100 * row.difference << " % | " << row.rejected << " | " << row.filled
         << " | " << std::setprecision(2) << row.ndf.seconds << std::setprecision(4) << " |\n";
  return text.str();
}

std::string to_json(const Study& study) {
  nlohmann::json rows = nlohmann::json::array();
  for (const StudyRow& row : study.rows)
    rows.push_back({{"ndf", row.ndf.method.name},
                    {"scans", row.ndf.scans},
                    {"width_x", row.width_x},
                    {"width_y", row.width_y},
                    {"total_variation", row.difference},
                    {"rejected", row.rejected},
                    {"filled", row.filled},
                    {"seconds", row.ndf.seconds}});
  return nlohmann::json{{"title", study.title},
                        {"reference", study.reference},
                        {"rows", rows},
                        {"left_out", nlohmann::json::parse(to_json(study.left_out))}}
      .dump(1);
}

std::string to_csv(const Study& study) {
  std::ostringstream text;
  text << "ndf,scans,width_x,width_y,total_variation,rejected,filled,seconds\n" << std::setprecision(9);
  for (const StudyRow& row : study.rows)
    text << '"' << row.ndf.method.name << "\"," << row.ndf.scans << ',' << row.width_x << ',' << row.width_y
         << ',' << row.difference << ',' << row.rejected << ',' << row.filled << ',' << row.ndf.seconds
         << '\n';
  return text.str();
}

}  // namespace micro
