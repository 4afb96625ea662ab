#include "pipelines/plan.h"

#include <nlohmann/json.hpp>

namespace micro {

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
