#include "pipelines/lettering.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace micro {
namespace {

/// A letter: seven rows of five dots, the leftmost dot in bit 4.
struct Glyph {
  char letter;
  std::array<std::uint8_t, 7> rows;
};

/// Capitals, digits and the signs that file and method names need; anything else is drawn as a box.
constexpr std::array kGlyphs = {
    Glyph{' ', {0, 0, 0, 0, 0, 0, 0}},        Glyph{'.', {0, 0, 0, 0, 0, 12, 12}},
    Glyph{'-', {0, 0, 0, 31, 0, 0, 0}},       Glyph{'_', {0, 0, 0, 0, 0, 0, 31}},
    Glyph{'/', {0, 1, 2, 4, 8, 16, 0}},       Glyph{':', {0, 12, 12, 0, 12, 12, 0}},
    Glyph{'+', {0, 4, 4, 31, 4, 4, 0}},       Glyph{'(', {2, 4, 8, 8, 8, 4, 2}},
    Glyph{')', {8, 4, 2, 2, 2, 4, 8}},        Glyph{'%', {24, 25, 2, 4, 8, 19, 3}},
    Glyph{'<', {2, 4, 8, 16, 8, 4, 2}},       Glyph{',', {0, 0, 0, 0, 12, 4, 8}},
    Glyph{'=', {0, 0, 31, 0, 31, 0, 0}},      Glyph{'0', {14, 17, 19, 21, 25, 17, 14}},
    Glyph{'1', {4, 12, 4, 4, 4, 4, 14}},      Glyph{'2', {14, 17, 1, 2, 4, 8, 31}},
    Glyph{'3', {31, 2, 4, 2, 1, 17, 14}},     Glyph{'4', {2, 6, 10, 18, 31, 2, 2}},
    Glyph{'5', {31, 16, 30, 1, 1, 17, 14}},   Glyph{'6', {6, 8, 16, 30, 17, 17, 14}},
    Glyph{'7', {31, 1, 2, 4, 8, 8, 8}},       Glyph{'8', {14, 17, 17, 14, 17, 17, 14}},
    Glyph{'9', {14, 17, 17, 15, 1, 2, 12}},   Glyph{'A', {14, 17, 17, 31, 17, 17, 17}},
    Glyph{'B', {30, 17, 17, 30, 17, 17, 30}}, Glyph{'C', {14, 17, 16, 16, 16, 17, 14}},
    Glyph{'D', {28, 18, 17, 17, 17, 18, 28}}, Glyph{'E', {31, 16, 16, 30, 16, 16, 31}},
    Glyph{'F', {31, 16, 16, 30, 16, 16, 16}}, Glyph{'G', {14, 17, 16, 23, 17, 17, 15}},
    Glyph{'H', {17, 17, 17, 31, 17, 17, 17}}, Glyph{'I', {14, 4, 4, 4, 4, 4, 14}},
    Glyph{'J', {7, 2, 2, 2, 2, 18, 12}},      Glyph{'K', {17, 18, 20, 24, 20, 18, 17}},
    Glyph{'L', {16, 16, 16, 16, 16, 16, 31}}, Glyph{'M', {17, 27, 21, 21, 17, 17, 17}},
    Glyph{'N', {17, 17, 25, 21, 19, 17, 17}}, Glyph{'O', {14, 17, 17, 17, 17, 17, 14}},
    Glyph{'P', {30, 17, 17, 30, 16, 16, 16}}, Glyph{'Q', {14, 17, 17, 17, 21, 18, 13}},
    Glyph{'R', {30, 17, 17, 30, 20, 18, 17}}, Glyph{'S', {15, 16, 16, 14, 1, 1, 30}},
    Glyph{'T', {31, 4, 4, 4, 4, 4, 4}},       Glyph{'U', {17, 17, 17, 17, 17, 17, 14}},
    Glyph{'V', {17, 17, 17, 17, 17, 10, 4}},  Glyph{'W', {17, 17, 17, 21, 21, 21, 10}},
    Glyph{'X', {17, 17, 10, 4, 10, 17, 17}},  Glyph{'Y', {17, 17, 17, 10, 4, 4, 4}},
    Glyph{'Z', {31, 1, 2, 4, 8, 16, 31}},
};

const std::array<std::uint8_t, 7>& glyph(char letter) {
  static constexpr std::array<std::uint8_t, 7> kBox = {31, 17, 17, 17, 17, 17, 31};
  const char capital = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  const auto found =
      std::find_if(kGlyphs.begin(), kGlyphs.end(), [&](const Glyph& g) { return g.letter == capital; });
  return found == kGlyphs.end() ? kBox : found->rows;
}

}  // namespace

void draw_text(Picture& picture, Eigen::Index row, Eigen::Index col, Eigen::Index width,
               std::string_view text) {
  const auto fits = static_cast<std::size_t>(std::max<Eigen::Index>(0, width) / kLetterWidth);
  if (text.size() > fits) text.remove_prefix(text.size() - fits);
  for (const char letter : text) {
    const auto& rows = glyph(letter);
    for (Eigen::Index j = 0; j < kLetterHeight; ++j)
      for (Eigen::Index i = 0; i < kLetterWidth - 1; ++i) {
        const bool inside =
            row + j >= 0 && row + j < picture.rows() && col + i >= 0 && col + i < picture.cols();
        if (inside && ((rows[static_cast<std::size_t>(j)] >> (4 - i)) & 1)) picture(row + j, col + i) = kInk;
      }
    col += kLetterWidth;
  }
}

}  // namespace micro
