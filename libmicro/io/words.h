#pragma once

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

#include "io/bytes.h"
#include "io/printable.h"

namespace micro {

inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/// The whole of `text` as a number, after an optional plus sign; false if it is none.
template <typename T>
bool parse_number(std::string_view text, T& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && rest == text.data() + text.size();
}

/// Walks over the text of a file, one word or line at a time. Blocks of words are closed by one word of its
/// own, like "#".
class Words {
 public:
  Words(const FileBytes& file, std::string_view closing)
      : file_(file), closing_(closing), at_(file.text().data()), end_(file.text().data() + file.size()) {}

  /// The next line, without its end (LF or CRLF).
  std::string_view line() {
    file_.require(at_ < end_, "is cut in its header");
    const char* begin = at_;
    const char* end = std::find(at_, end_, '\n');
    at_ = end < end_ ? end + 1 : end_;
    if (end > begin && end[-1] == '\r') --end;
    return {begin, end};
  }

  /// The next word; empty at the end of the file.
  std::string_view word() {
    while (at_ < end_ && is_blank(*at_))
      ++at_;
    const char* begin = at_;
    while (at_ < end_ && !is_blank(*at_))
      ++at_;
    return {begin, at_};
  }

  /// The next word, without passing it.
  std::string_view peek() const { return Words(*this).word(); }

  /// The next word as a number. Throws FileError unless it is one.
  template <typename T>
  T number() {
    T value{};
    const std::string_view text = word();
    if (!parse_number(text, value)) {
      file_.require(!text.empty() && text != closing_,
                    "is cut: it has fewer heights than its header promises");
      throw FileError(file_.path(), in_quotes(text) + " stands where a number should");
    }
    return value;
  }

  /// Passes the word that closes a block of heights. A file without its last one is cut.
  void close_block() {
    const std::string_view text = word();
    if (text == closing_) return;
    throw FileError(file_.path(), text.empty() ? "is cut: the " + std::string(closing_) +
                                                     " that closes the heights is missing"
                                               : "has more heights than its header promises");
  }

  /// Passes everything up to and with the next closing character.
  void skip_block() {
    at_ = std::find(at_, end_, closing_.front());
    file_.require(at_ < end_, "is cut: what closes the intensities is missing");
    ++at_;
  }

  std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }

 private:
  const FileBytes& file_;
  std::string_view closing_;
  const char* at_;
  const char* end_;
};

}  // namespace micro
