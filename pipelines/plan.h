#pragma once

#include <cstdint>
#include <map>
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

Stage ran(std::string name, std::string reason);
Stage left_out(std::string name, std::string reason);
Stage stage_if(bool done, std::string name, std::string reason);

/// "1 scan", "2 scans".
std::string counted(std::int64_t n, const std::string& what);

/// Scans that something does not apply to, by the reason why.
using Refusals = std::map<std::string, std::int64_t>;

/// Adds one count to another, reason by reason.
void add(Refusals& refusals, const Refusals& more);

/// "2 scans left out: …; 1 scan left out: …", or nothing.
std::string to_text(const Refusals& refusals);

/// The plan as JSON: [{"stage", "ran", "reason"}, …].
std::string to_json(const Plan& plan);

/// A few lines for people: what ran, what was left out and why.
std::string to_text(const Plan& plan);

}  // namespace micro
