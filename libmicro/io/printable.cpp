#include "io/printable.h"

namespace micro {

std::string printable(std::string_view words, std::size_t most) {
  constexpr unsigned char kSpace = 0x20, kDelete = 0x7f, kContinued = 0x80, kControl = 0xa0;
  constexpr char kLatin = '\xC2';  // UTF-8: what begins U+0080 to U+00BF, of which the first 32 are controls
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(words[k]); };
  std::size_t end = words.size();
  if (end > most)
    for (end = most; end > 0 && byte(end) >= kContinued && byte(end) < 0xC0;)
      --end;  // no half of a character
  std::string text;
  for (std::size_t k = 0; k < end; ++k) {
    if (words[k] == kLatin && k + 1 < end && byte(k + 1) >= kContinued && byte(k + 1) < kControl) {
      text += '?';
      ++k;
    } else {
      text += byte(k) < kSpace || byte(k) == kDelete ? '?' : words[k];
    }
  }
  return end < words.size() ? text + "…" : text;
}

std::string in_quotes(std::string_view words) {
  constexpr std::size_t most = 40;
  return "\"" + printable(words, most) + "\"";
}

}  // namespace micro
