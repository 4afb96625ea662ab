#pragma once

#include <string>

namespace micro::testing {

/// How a command ended and what it wrote.
struct ProgramOutcome {
  int code = -1;  ///< of exit; 128 + the signal's number if one ended it
  std::string out;
};

/// Runs a shell command line to its end; `out` is its stdout (redirect stderr as the test needs it).
ProgramOutcome run_program(const std::string& command_line);

/// The `microbrdf` of this build; compiled only into programs that define MICROBRDF_PROGRAM.
#ifdef MICROBRDF_PROGRAM
inline std::string microbrdf(const std::string& arguments) {
  return std::string(MICROBRDF_PROGRAM) + " " + arguments;
}
#endif

}  // namespace micro::testing
