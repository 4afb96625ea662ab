#pragma once

#include <CLI/CLI.hpp>

namespace micro::tools {

/// What every subcommand understands.
struct CommonOptions {
  int threads = 0;        ///< 0: one per processor
  bool json = false;      ///< print a machine-readable summary on stdout
  bool progress = false;  ///< show progress even when stderr is no terminal
};

/// Adds --threads and --json, and a footer with an example and the exit codes to --help.
void add_common_options(CLI::App& app, CommonOptions& options, const char* example);

/// Adds --progress, for what works through many scans before it says anything.
void add_progress(CLI::App& app, CommonOptions& options);

/// The exit codes as a line of --help.
constexpr const char* kExitCodes =
    "Exit codes: 0 done, 1 some scans failed and the rest is done, 2 usage, 3 nothing could be done.\n";

/// True if progress should be drawn: asked for, or stderr is a terminal.
bool shows_progress(const CommonOptions& options);

}  // namespace micro::tools
