#pragma once

#include <string_view>

namespace micro {

/// The version that results are stamped with.
std::string_view version();

}  // namespace micro
