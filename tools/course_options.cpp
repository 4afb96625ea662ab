#include "tools/course_options.h"

#include <signal.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>

namespace micro::tools {
namespace {

// What a signal handler may touch.
volatile std::sig_atomic_t stop_asked = 0;

extern "C" void ask_to_stop(int) {
  stop_asked = 1;
  constexpr char kText[] = "microbrdf: stopping after the scan at hand; a second signal stops at once\n";
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, kText, sizeof kText - 1);
}

void stop_on_signals() {
  struct sigaction action {};
  action.sa_handler = ask_to_stop;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM})
    ::sigaction(signal, &action, nullptr);
}

Shard shard_of(const std::string& text) {
  Shard shard;
  int end = 0;
  if (std::sscanf(text.c_str(), "%d/%d%n", &shard.index, &shard.count, &end) == 2 &&
      static_cast<std::size_t>(end) == text.size() && shard.index >= 1 && shard.index <= shard.count)
    return shard;
  throw CLI::ValidationError("--shard: '" + text + "' is no i/n with 1 ≤ i ≤ n, like 2/4");
}

}  // namespace

void add_course_options(CLI::App& app, CourseOptions& options) {
  app.add_option("--shard", options.shard,
                 "i/n: only every n-th scan, beginning with the i-th; microbrdf merge joins the n results");
}

Course make_course(const CourseOptions& options, const std::filesystem::path& checkpoint) {
  Course course;
  course.checkpoint = checkpoint;
  if (!options.shard.empty()) course.shard = shard_of(options.shard);
  stop_on_signals();
  course.interrupted = [] { return stop_asked != 0; };
  return course;
}

void note_resumed(const NdfResult& result) {
  if (result.resumed == 0) return;
  std::fprintf(stderr, "microbrdf: %s of an earlier run that was stopped, %zu in all\n",
               counted(result.resumed, "scan").c_str(), result.scans.size());
}

}  // namespace micro::tools
