#include "pipelines/plan.h"

#include <nlohmann/json.hpp>

namespace micro {

Stage ran(std::string name, std::string reason) {
  return {Stage::Outcome::Ran, std::move(name), std::move(reason)};
}

Stage left_out(std::string name, std::string reason) {
  return {Stage::Outcome::LeftOut, std::move(name), std::move(reason)};
}

Stage stage_if(bool done, std::string name, std::string reason) {
  return done ? ran(std::move(name), std::move(reason)) : left_out(std::move(name), std::move(reason));
}

std::string counted(std::int64_t n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

void add(Refusals& refusals, const Refusals& more) {
  for (const auto& [reason, scans] : more)
    refusals[reason] += scans;
}

std::string to_text(const Refusals& refusals) {
  std::string text;
  for (const auto& [reason, scans] : refusals)
    text += (text.empty() ? "" : "; ") + counted(scans, "scan") + " left out: " + reason;
  return text;
}

std::string to_json(const Plan& plan) {
  nlohmann::json stages = nlohmann::json::array();
  for (const Stage& stage : plan)
    stages.push_back(
        {{"stage", stage.name}, {"ran", stage.outcome == Stage::Outcome::Ran}, {"reason", stage.reason}});
  return stages.dump(1);
}

std::string to_text(const Plan& plan) {
  std::string ran, left_out;
  for (const Stage& stage : plan) {
    std::string& text = stage.outcome == Stage::Outcome::Ran ? ran : left_out;
    text += "  " + stage.name + (stage.reason.empty() ? "" : ": " + stage.reason) + "\n";
  }
  return (ran.empty() ? "" : "Did:\n" + ran) + (left_out.empty() ? "" : "Left out:\n" + left_out);
}

}  // namespace micro
