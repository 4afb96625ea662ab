#pragma once

#include <cstdio>
#include <nlohmann/json.hpp>

namespace micro::tools {

/// Prints a machine-readable summary on stdout. File names may hold any bytes: what is not UTF-8 is replaced.
template <typename Json>
void print_json(const Json& summary) {
  std::printf("%s\n", summary.dump(1, ' ', false, Json::error_handler_t::replace).c_str());
}

}  // namespace micro::tools
