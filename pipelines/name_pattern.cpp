#include "pipelines/name_pattern.h"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "core/error.h"

namespace micro {
namespace {

bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

}  // namespace

NamePattern::NamePattern(const std::string& pattern) {
  std::string literal;
  for (std::size_t k = 0; k < pattern.size();) {
    const bool row = pattern.compare(k, 5, "{row}") == 0, col = pattern.compare(k, 5, "{col}") == 0;
    if (!row && !col) {
      literal += pattern[k++];
      continue;
    }
    const Number number = row ? Number::kRow : Number::kCol;
    const auto is_same = [&](const Piece& piece) { return piece.number == number; };
    if (std::any_of(pieces_.begin(), pieces_.end(), is_same))
      throw InputError("the layout '" + pattern + "' says the same number twice");
    if (!pieces_.empty() && (literal.empty() || is_digit(literal.front())))
      throw InputError("the layout '" + pattern + "' does not say where its first number ends");
    pieces_.push_back({literal, number});
    literal.clear();
    k += 5;
  }
  if (pieces_.empty())
    throw InputError("the layout '" + pattern + "' has neither {row} nor {col}, as in r{row}_c{col}");
  if (!literal.empty() && is_digit(literal.front()))
    throw InputError("the layout '" + pattern + "' does not say where its last number ends");
  after_ = literal;
}

std::optional<NamePattern::Place> NamePattern::match(const std::string& name, std::size_t start) const {
  Place place{0, 0};
  std::size_t at = start;
  for (const Piece& piece : pieces_) {
    if (name.compare(at, piece.before.size(), piece.before) != 0) return std::nullopt;
    at += piece.before.size();
    const auto end = std::find_if_not(name.begin() + static_cast<std::ptrdiff_t>(at), name.end(), is_digit);
    const std::string digits(name.begin() + static_cast<std::ptrdiff_t>(at), end);
    if (digits.empty()) return std::nullopt;
    Eigen::Index& value = piece.number == Number::kRow ? place.row : place.col;
    if (std::from_chars(digits.data(), digits.data() + digits.size(), value).ec != std::errc())
      throw InputError(name + ": a row or column is too large");
    at += digits.size();
  }
  if (name.compare(at, after_.size(), after_) != 0) return std::nullopt;
  return place;
}

std::optional<NamePattern::Place> NamePattern::find(const std::string& name) const {
  for (std::size_t start = 0; start < name.size(); ++start)
    if (const auto place = match(name, start)) return place;
  return std::nullopt;
}

}  // namespace micro
