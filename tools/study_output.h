#pragma once

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "io/atomic_file.h"
#include "tools/commands.h"
#include "tools/common_options.h"
#include "tools/json_output.h"

namespace micro::tools {

/// What a study of made surfaces leaves: files STEM.csv and STEM.md, and the table, or {"rows": […]}, on
/// stdout.
struct StudyOutput {
  std::filesystem::path stem;
  std::string csv, markdown;
  nlohmann::json rows;
};

inline int conclude(const StudyOutput& study, const CommonOptions& options) {
  write_text_file(study.stem.string() + ".csv", study.csv);
  write_text_file(study.stem.string() + ".md", study.markdown);
  if (options.json)
    print_json(nlohmann::json{{"rows", study.rows}});
  else
    std::printf("%s", study.markdown.c_str());
  return kDone;
}

}  // namespace micro::tools
