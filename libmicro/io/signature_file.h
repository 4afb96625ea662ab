#pragma once

#include <filesystem>

#include "distribution/signature.h"

namespace micro {

/// Reads an instrument signature measured from a mirror: text rows `angle response`, the half-vector angle in
/// degrees, ascending from 0, `#` starts a comment. Throws FileError naming the line.
Signature read_signature(const std::filesystem::path& path);

}  // namespace micro
