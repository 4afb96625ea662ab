#include "pipelines/origin.h"

#include <chrono>
#include <ctime>
#include <iomanip>
#include <sstream>

#include "pipelines/version.h"

namespace micro {

Origin origin_of(const std::string& command) {
  const std::time_t time = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  gmtime_r(&time, &utc);
  std::ostringstream created;
  created << std::put_time(&utc, "%Y-%m-%dT%H:%M:%SZ");
  return {.version = std::string(version()), .created = created.str(), .command = command};
}

}  // namespace micro
