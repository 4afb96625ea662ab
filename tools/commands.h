#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace micro::tools {

/// Exit codes of every subcommand.
enum ExitCode : int {
  kDone = 0,        ///< everything asked for is done
  kSomeFailed = 1,  ///< some scans failed, each is named; the rest is done
  kUsage = 2,       ///< the command line makes no sense
  kNothing = 3,     ///< nothing could be done, or another run holds the output
};

/// A subcommand: its options are added to `app`; the returned function runs it after parsing and gives the
/// exit code.
using Run = std::function<int()>;
using AddCommand = Run (*)(CLI::App& app);

Run add_info(CLI::App& app);
Run add_convert(CLI::App& app);
Run add_synth(CLI::App& app);
Run add_ndf(CLI::App& app);
Run add_fit(CLI::App& app);
Run add_brdf(CLI::App& app);
Run add_run(CLI::App& app);
Run add_merge(CLI::App& app);
Run add_texture(CLI::App& app);
Run add_study(CLI::App& app);
Run add_wave_study(CLI::App& app);       ///< of `study`
Run add_shadowing_study(CLI::App& app);  ///< of `study`
Run add_coat_study(CLI::App& app);       ///< of `study`

}  // namespace micro::tools
