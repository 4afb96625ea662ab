#include "pipelines/pitch_groups.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace micro {
namespace {

/// Pitches that differ by less are those of one instrument setting.
constexpr double kTolerance = 0.01;

std::string pitch_of(const PitchGroup& group) {
  std::ostringstream text;
  text << group.dx << " × " << group.dy << " µm";
  return text.str();
}

std::string describe(const std::vector<PitchGroup>& groups, std::string_view remedy) {
  constexpr std::size_t kNamed = 20;
  std::ostringstream text;
  text << "the scans have " << groups.size() << " different pitches and are no one dataset" << remedy << ":";
  for (const PitchGroup& group : groups) {
    text << (&group == &groups.front() ? " " : "; ") << pitch_of(group) << ": ";
    const std::size_t named = std::min(kNamed, group.sources.size());
    for (std::size_t k = 0; k < named; ++k)
      text << (k > 0 ? ", " : "") << group.sources[k];
    if (group.sources.size() > named) text << " and " << group.sources.size() - named << " more";
  }
  return text.str();
}

}  // namespace

void PitchGroups::add(double dx, double dy, const std::string& source) {
  for (PitchGroup& group : groups_)
    if (std::abs(dx - group.dx) <= kTolerance * group.dx &&
        std::abs(dy - group.dy) <= kTolerance * group.dy) {
      group.sources.push_back(source);
      return;
    }
  groups_.push_back({dx, dy, {source}});
}

MixedPitches::MixedPitches(const PitchGroups& groups, std::vector<FailedScan> failed, std::string_view remedy)
    : InputError(describe(groups.groups(), remedy)), failed_(std::move(failed)) {
  for (const PitchGroup& group : groups.groups())
    for (const std::string& source : group.sources)
      failed_.push_back({source, "its pitch of " + pitch_of(group) + " is not that of the other scans"});
}

}  // namespace micro
