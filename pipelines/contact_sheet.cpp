#include <algorithm>
#include <array>
#include <cctype>
#include <iomanip>
#include <sstream>
#include <string_view>

#include "io/png.h"
#include "pipelines/result_file.h"
#include "pipelines/thumbnail.h"

namespace micro {
namespace {

constexpr Eigen::Index kMargin = 12, kLabel = 16;
constexpr Rgb kPaper = {255, 255, 255}, kInk = {40, 40, 40};

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
constexpr Eigen::Index kGlyphWidth = 6;

const std::array<std::uint8_t, 7>& glyph(char letter) {
  static constexpr std::array<std::uint8_t, 7> kBox = {31, 17, 17, 17, 17, 17, 31};
  const char capital = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  const auto found =
      std::find_if(kGlyphs.begin(), kGlyphs.end(), [&](const Glyph& g) { return g.letter == capital; });
  return found == kGlyphs.end() ? kBox : found->rows;
}

/// Draws text from (row, col) on, cut off after `width` points; a name too long loses its beginning.
void draw(Picture& sheet, Eigen::Index row, Eigen::Index col, Eigen::Index width, std::string_view text) {
  const auto fits = static_cast<std::size_t>(width / kGlyphWidth);
  if (text.size() > fits) text.remove_prefix(text.size() - fits);
  for (const char letter : text) {
    const auto& rows = glyph(letter);
    for (Eigen::Index j = 0; j < 7; ++j)
      for (Eigen::Index i = 0; i < 5; ++i)
        if ((rows[static_cast<std::size_t>(j)] >> (4 - i)) & 1) sheet(row + j, col + i) = kInk;
    col += kGlyphWidth;
  }
}

struct Tile {
  Picture picture;
  std::string label;
};

std::vector<Tile> tiles_of(const NdfResult& result) {
  std::vector<Tile> tiles;
  std::size_t next = 0;
  for (const ScanRecord& scan : result.scans)
    if (!scan.failure && next < result.thumbnails.size())
      tiles.push_back({result.thumbnails[next++], scan.source});
  for (const NdfOfScans& ndf : result.ndfs) {
    DiskPicture disk = picture_of(ndf.density);
    std::ostringstream label;
    label << "NDF " << ndf.method.name << " to sin " << std::setprecision(2) << disk.extent;
    tiles.push_back({std::move(disk.picture), label.str()});
  }
  return tiles;
}

}  // namespace

void write_contact_sheet(const std::filesystem::path& path, const NdfResult& result) {
  const std::vector<Tile> tiles = tiles_of(result);
  if (tiles.empty()) return;
  const auto count = static_cast<Eigen::Index>(tiles.size());
  const Eigen::Index columns = std::min<Eigen::Index>(count, 4), rows = (count + columns - 1) / columns;
  const Eigen::Index cell_width = kThumbnail + kMargin, cell_height = kThumbnail + kLabel + kMargin;
  Picture sheet = Picture::Constant(rows * cell_height + kMargin, columns * cell_width + kMargin, kPaper);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto& [picture, label] = tiles[static_cast<std::size_t>(k)];
    const Eigen::Index row = kMargin + k / columns * cell_height, col = kMargin + k % columns * cell_width;
    draw(sheet, row, col, kThumbnail, label);
    sheet.block(row + kLabel, col, picture.rows(), picture.cols()) = picture;
  }
  write_png(path, sheet);
}

}  // namespace micro
