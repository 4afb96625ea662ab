#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace micro {

/// One stage of a run: done, or left out, and why.
struct Stage {
  enum class Outcome { Ran, LeftOut } outcome;
  std::string name;
  std::string reason;
};

/// What a run did and what it left out, in the order of the recipe.
using Plan = std::vector<Stage>;

/// The plan as JSON: [{"stage", "ran", "reason"}, …].
std::string to_json(const Plan& plan);

/// A few lines for people: what ran, what was left out and why.
std::string to_text(const Plan& plan);

}  // namespace micro
