#include "testing/run_program.h"

#include <sys/wait.h>

#include <array>
#include <cstdio>

namespace micro::testing {

ProgramOutcome run_program(const std::string& command_line) {
  ProgramOutcome outcome;
  std::FILE* pipe = ::popen(command_line.c_str(), "r");
  if (!pipe) return outcome;
  std::array<char, 4096> part;
  for (std::size_t n; (n = std::fread(part.data(), 1, part.size(), pipe)) > 0;)
    outcome.out.append(part.data(), n);
  const int status = ::pclose(pipe);
  outcome.code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  return outcome;
}

}  // namespace micro::testing
