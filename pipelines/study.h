#pragma once

#include <string>
#include <vector>

#include "pipelines/ndf_of_scans.h"

namespace micro {

/// One line of a study: an NDF and how far it is from the study's reference.
struct StudyRow {
  NdfOfScans ndf;
  double width_x = 0, width_y = 0;  ///< half interquartile ranges of m_x, m_y
  double difference = 0;            ///< total variation against the reference at 1.5° resolution, 0 to 1
  Eigen::Index rejected = 0, filled = 0;  ///< points that the filters changed
};

/// An experiment of the paper on the user's own scans.
struct Study {
  std::string title, reference;
  std::vector<StudyRow> rows;     ///< none if no scan gave the reference
  std::vector<ScanRecord> scans;  ///< in the order of the listing
  Plan left_out;                  ///< normal distributions that no scan gave, and why
};

/// Sensitivity of the filtered NDF to the window's σ, and the naive NDF beside it [Dong15 §5.1, Fig. 5]; the
/// reference is σ = 1 µm, or the first σ if that is not among them. A σ that the pitch does not resolve is
/// left out.
Study study_sigma(const ScanListing& listing, const NdfRequest& request, const std::vector<double>& sigmas,
                  const std::function<void(const Progress&)>& report);

/// Outlier rejection and hole filling, off and on [Dong15 §4.1]; the reference is everything off.
Study study_filters(const ScanListing& listing, const NdfRequest& request,
                    const std::function<void(const Progress&)>& report);

/// A study as a Markdown table.
std::string to_markdown(const Study& study);

/// A study as JSON: {"title", "reference", "rows": [{"ndf", "scans", "width_x", …}]}.
std::string to_json(const Study& study);

/// A study as comma-separated values, one line a row.
std::string to_csv(const Study& study);

}  // namespace micro
