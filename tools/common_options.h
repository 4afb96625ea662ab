#pragma once

#include <CLI/CLI.hpp>

namespace micro::tools {

/// What every subcommand understands.
struct CommonOptions {
  int threads = 0;        ///< 0: one per processor
  bool json = false;      ///< print a machine-readable summary on stdout
  bool progress = false;  ///< show progress even when stderr is no terminal
};

/// Adds --threads, --json and --progress, and a footer with an example to --help.
void add_common_options(CLI::App& app, CommonOptions& options, const char* example);

/// True if progress should be drawn: asked for, or stderr is a terminal.
bool shows_progress(const CommonOptions& options);

}  // namespace micro::tools
