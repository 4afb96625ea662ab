#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace micro {

/// MD5 of bytes, 32 lower-case hexadecimal digits: formats ask for it, nothing relies on it. Empty where the
/// cryptographic library refuses to compute it.
std::string md5_of(std::span<const std::byte> bytes);

}  // namespace micro
