#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "pipelines/ndf_of_scans.h"

namespace micro::tools {

/// How a batch is carried out, as typed.
struct CourseOptions {
  std::string shard;  ///< "2/4"; empty: all scans
};

/// Adds --shard.
void add_course_options(CLI::App& app, CourseOptions& options);

/// The course of a run that keeps unfinished work in `checkpoint`, and stops with it on SIGINT and SIGTERM (a
/// second one ends the program at once). Throws CLI::ValidationError if --shard is no i/n.
Course make_course(const CourseOptions& options, const std::filesystem::path& checkpoint);

/// Says on stderr what an earlier run had done already.
void note_resumed(const NdfResult& result);

}  // namespace micro::tools
