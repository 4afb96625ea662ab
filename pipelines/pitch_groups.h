#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace micro {

/// Scans of one pitch, to 1 %.
struct PitchGroup {
  double dx, dy;                     ///< µm, of its first scan
  std::vector<std::string> sources;  ///< in the order they came
};

/// Sorts scans into groups of equal pitch as they come.
class PitchGroups {
 public:
  void add(double dx, double dy, const std::string& source);
  bool mixed() const { return groups_.size() > 1; }
  const std::vector<PitchGroup>& groups() const { return groups_; }

 private:
  std::vector<PitchGroup> groups_;
};

/// A scan that is not part of a result, and why.
struct FailedScan {
  std::string source, message;
};

/// Scans of different pitch are no one dataset: the sentence names every group, and what is in it as far as
/// people read on.
class MixedPitches : public InputError {
 public:
  /// `failed`: scans that could not be read at all. `remedy`: what takes them together all the same, in
  /// brackets.
  MixedPitches(const PitchGroups& groups, std::vector<FailedScan> failed, std::string_view remedy = "");
  /// Every scan and why it is not used, those that could not be read first.
  const std::vector<FailedScan>& failed() const { return failed_; }

 private:
  std::vector<FailedScan> failed_;
};

}  // namespace micro
