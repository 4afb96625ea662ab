#include <algorithm>
#include <cassert>
#include <iomanip>
#include <sstream>

#include "io/png.h"
#include "pipelines/lettering.h"
#include "pipelines/result_file.h"
#include "pipelines/thumbnail.h"

namespace micro {
namespace {

constexpr Eigen::Index kMargin = 12, kLabel = 16;
constexpr Rgb kPaper = {255, 255, 255};

struct Tile {
  Picture picture;
  std::string label;
};

Tile tile_of(const NdfOfScans& ndf, const DiskView& view) {
  std::ostringstream label;
  label << "NDF " << ndf.method.name << " to sin " << std::setprecision(2) << view.extent;
  return {picture_of(ndf.density, view), label.str()};
}

std::vector<Tile> tiles_of(const NdfResult& result) {
  std::vector<Tile> tiles;
  std::size_t next = 0;
  for (const ScanRecord& scan : result.scans)
    if (!scan.failure && next < result.thumbnails.size())
      tiles.push_back({result.thumbnails[next++], scan.source});
  for (const NdfOfScans& ndf : result.ndfs)
    tiles.push_back(tile_of(ndf, view_of(ndf.density)));
  return tiles;
}

/// At least one tile.
Picture sheet_of(const std::vector<Tile>& tiles) {
  const auto count = static_cast<Eigen::Index>(tiles.size());
  const Eigen::Index columns = std::min<Eigen::Index>(count, 4), rows = (count + columns - 1) / columns;
  const Eigen::Index cell_width = kThumbnail + kMargin, cell_height = kThumbnail + kLabel + kMargin;
  Picture sheet = Picture::Constant(rows * cell_height + kMargin, columns * cell_width + kMargin, kPaper);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto& [picture, label] = tiles[static_cast<std::size_t>(k)];
    const Eigen::Index row = kMargin + k / columns * cell_height, col = kMargin + k % columns * cell_width;
    draw_text(sheet, row, col, kThumbnail, label);
    sheet.block(row + kLabel, col, picture.rows(), picture.cols()) = picture;
  }
  return sheet;
}

}  // namespace

void write_contact_sheet(const std::filesystem::path& path, const NdfResult& result) {
  const std::vector<Tile> tiles = tiles_of(result);
  if (!tiles.empty()) write_png(path, sheet_of(tiles));
}

Picture comparison_sheet(const std::vector<NdfOfScans>& ndfs) {
  DiskView widest{};
  for (const NdfOfScans& ndf : ndfs) {
    assert(ndf.density.grid == ndfs.front().density.grid);
    const DiskView view = view_of(ndf.density);
    if (view.half > widest.half) widest = view;
  }
  std::vector<Tile> tiles;
  for (const NdfOfScans& ndf : ndfs)
    tiles.push_back(tile_of(ndf, {widest.half, widest.extent, ndf.density.density.maxCoeff()}));
  return sheet_of(tiles);
}

}  // namespace micro
