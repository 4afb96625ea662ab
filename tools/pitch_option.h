#pragma once

#include <CLI/CLI.hpp>

#include "io/scan.h"

namespace micro::tools {

/// Adds --pitch P or X,Y: the distance between points, in µm once stored, for files that don't say it.
CLI::Option* add_pitch(CLI::App& app, ReadOptions& options);

}  // namespace micro::tools
