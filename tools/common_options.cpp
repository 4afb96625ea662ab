#include "tools/common_options.h"

#include <unistd.h>

#include <string>

#include "core/parallel.h"

namespace micro::tools {

void add_common_options(CLI::App& app, CommonOptions& options, const char* example) {
  app.add_option("--threads", options.threads, "Threads to use (default: one per processor)")
      ->check(CLI::Range(1, 1024));
  app.add_flag("--json", options.json, "Print a machine-readable summary on stdout");
  app.footer(std::string("Example:\n  ") + example + "\n" + kExitCodes);
  app.parse_complete_callback([&options] { set_thread_count(options.threads); });
}

void add_progress(CLI::App& app, CommonOptions& options) {
  app.add_flag("--progress", options.progress, "Show progress on stderr even when it is no terminal");
}

bool shows_progress(const CommonOptions& options) {
  return options.progress || isatty(STDERR_FILENO) != 0;
}

}  // namespace micro::tools
