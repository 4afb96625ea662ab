#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "pipelines/version.h"
#include "tools/commands.h"

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
    Command{"study", "The paper's experiments on your own scans", micro::tools::add_study},
};

int fail(const char* message, int code) {
  std::fprintf(stderr, "microbrdf: %s\n", message);
  return code;
}

int run(int argc, char** argv) {
  using micro::tools::Run;
  CLI::App app("microbrdf: from measured rough metal surfaces to how they look");
  app.set_version_flag("--version", "microbrdf " + std::string(micro::version()));
  app.require_subcommand(1);
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
    return app.exit(error) == 0 ? micro::tools::kDone : micro::tools::kUsage;
  }
  return micro::tools::kUsage;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const micro::InputError& error) {
    return fail(error.what(), micro::tools::kNothing);
  } catch (const std::bad_alloc&) {
    return fail("not enough memory for this request", micro::tools::kNothing);
  } catch (const std::exception& error) {
    return fail(error.what(), micro::tools::kNothing);
  }
}
