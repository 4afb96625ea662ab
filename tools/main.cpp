#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/memory.h"
#include "pipelines/pitch_groups.h"
#include "pipelines/version.h"
#include "tools/commands.h"
#include "tools/common_options.h"
#include "tools/json_output.h"
#include "tools/listing_output.h"

namespace {

using micro::tools::AddCommand;

struct Command {
  const char* name;
  const char* description;
  AddCommand add;
};

/// Every subcommand, in the order of `microbrdf --help`.
constexpr std::array kCommands = {
    Command{"run", "Everything the data allow: a directory of scans to result.h5, pictures and a report",
            micro::tools::add_run},
    Command{"info", "Size, missing points and ISO 25178 parameters of scans", micro::tools::add_info},
    Command{"convert", "Write a scan in another format", micro::tools::add_convert},
    Command{"synth", "Make a synthetic surface", micro::tools::add_synth},
    Command{"ndf", "Normal distributions of scans, averaged, in one HDF5 file", micro::tools::add_ndf},
    Command{"merge", "Join the results of the shards of one run", micro::tools::add_merge},
    Command{"fit", "Ellipsoid and Beckmann fits of every normal distribution in a file",
            micro::tools::add_fit},
    Command{"texture", "Ellipsoids of texels, and large textures made like them", micro::tools::add_texture},
    Command{"brdf", "Reflectance: slices, albedos, spectra and tables of a model", micro::tools::add_brdf},
    Command{"study", "The paper's experiments on your own scans", micro::tools::add_study},
};

/// A bad word where a subcommand should stand: CLI11 would call it an argument that was not expected.
std::optional<std::string> unknown_subcommand(const CLI::App& root, int argc, char** argv) {
  const CLI::App* app = &root;
  for (int k = 1; k < argc; ++k) {
    const std::string_view word = argv[k];
    const auto known = app->get_subcommands([](const CLI::App*) { return true; });
    const auto named = std::find_if(known.begin(), known.end(),
                                    [&](const CLI::App* command) { return command->get_name() == word; });
    if (named != known.end()) {
      app = *named;
      continue;
    }
    if (known.empty() || word.starts_with("-")) return std::nullopt;
    std::string names;
    for (const CLI::App* command : known)
      names += (names.empty() ? "" : ", ") + command->get_name();
    return "'" + std::string(word) + "' is no subcommand of " + app->get_name() + "; there are " + names;
  }
  return std::nullopt;
}

/// How a run ended that came to nothing.
struct Failure {
  int code;
  std::string message;
  std::vector<micro::FailedScan> scans;
};

/// Programs that asked for --json get an object on stdout, however the run ends.
int fail(const Failure& failure, int argc, char** argv) {
  std::fprintf(stderr, "microbrdf: %s\n", failure.message.c_str());
  if (failure.code == micro::tools::kUsage) std::fprintf(stderr, "Run with --help for more information.\n");
  if (std::find(argv, argv + argc, std::string_view("--json")) == argv + argc) return failure.code;
  nlohmann::json failed = nlohmann::json::array();
  for (const auto& [source, message] : failure.scans)
    failed.push_back({{"source", source}, {"message", message}});
  micro::tools::print_json(
      nlohmann::json{{"error", failure.message}, {"exit_code", failure.code}, {"failed", failed}});
  return failure.code;
}

/// Runs the subcommand that is named, or prints the help that is asked for.
int run(int argc, char** argv) {
  using micro::tools::Run;
  CLI::App app("microbrdf: from measured rough metal surfaces to how they look", "microbrdf");
  app.set_version_flag("--version", "microbrdf " + std::string(micro::version()));
  app.require_subcommand(1);
  app.footer(micro::tools::kExitCodes);
  std::vector<std::pair<CLI::App*, Run>> commands;
  for (const Command& command : kCommands) {
    CLI::App* subcommand = app.add_subcommand(command.name, command.description);
    commands.emplace_back(subcommand, command.add(*subcommand));
  }
  try {
    app.parse(argc, argv);
    // A subcommand may still find that its options do not go together.
    for (const auto& [subcommand, run_command] : commands)
      if (subcommand->parsed()) return run_command();
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    return fail({micro::tools::kUsage, unknown_subcommand(app, argc, argv).value_or(error.what()), {}}, argc,
                argv);
  }
  return micro::tools::kUsage;
}

}  // namespace

int main(int argc, char** argv) {
  using micro::tools::kNothing;
  micro::keep_freed_memory();
  try {
    return run(argc, argv);
  } catch (const micro::MixedPitches& error) {
    return fail({kNothing, error.what(), error.failed()}, argc, argv);
  } catch (const micro::FileError& error) {
    const std::string file = error.file().string();
    return fail({kNothing, micro::tools::printable_name(file) + ": " + error.fact(), {{file, error.fact()}}},
                argc, argv);
  } catch (const std::bad_alloc&) {
    return fail({kNothing, "not enough memory for this request", {}}, argc, argv);
  } catch (const std::exception& error) {
    return fail({kNothing, error.what(), {}}, argc, argv);
  }
}
