#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace micro {

/// Words of a file or of a library for a sentence: of what does not print (control characters, in one byte or
/// as UTF-8 has them) question marks are left, and what is longer than `most` bytes is cut.
std::string printable(std::string_view words, std::size_t most);

/// The same of at most 40 bytes, in quotation marks.
std::string in_quotes(std::string_view words);

}  // namespace micro
