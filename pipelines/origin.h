#pragma once

#include <string>

#include "io/microbrdf_hdf5.h"

namespace micro {

/// This version, now, and the command as typed.
Origin origin_of(const std::string& command);

}  // namespace micro
