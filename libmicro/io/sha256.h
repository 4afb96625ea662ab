#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace micro {

/// SHA-256 of a file's bytes, 64 hexadecimal digits. Throws FileError if it cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace micro
