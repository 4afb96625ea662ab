#pragma once

#include <cstddef>
#include <vector>

namespace micro {

/// The one-dimensional weights of a Gaussian window and its first moments, sampled at the grid's pitch and
/// cut off at ±radius samples: with x = (t − radius)·pitch/σ,
///   moment(m)[t] = x^m exp(−x²/2),  m = 0, 1, 2,  t = 0 … 2·radius.
/// Each row carries kPad zeros on both sides, so that several shifted outputs can share one loop over the
/// input.
class GaussianTaps {
 public:
  static constexpr std::size_t kPad = 4;

  /// pitch and sigma in µm. The window reaches kReach·σ, or `longest` samples where the surface is smaller
  /// than that.
  GaussianTaps(double pitch, double sigma, std::size_t longest);

  /// Beyond this many σ on either side the window is cut; truncation.h bounds what that does to a slope.
  static constexpr double kReach = 7;

  std::size_t radius() const { return radius_; }
  std::size_t size() const { return 2 * radius_ + 1; }
  const double* moment(std::size_t m) const { return taps_.data() + m * stride() + kPad; }
  std::size_t stride() const { return size() + 2 * kPad; }

 private:
  std::size_t radius_;
  std::vector<double> taps_;
};

/// Columns that a tile of TiledRows holds side by side.
constexpr std::size_t kTileColumns = 32;

/// rows × cols doubles, stored as vertical strips of kTileColumns columns, so that a pass across rows streams
/// through memory. The last strip is padded with columns that nobody reads.
class TiledRows {
 public:
  TiledRows(std::size_t rows, std::size_t cols)
      : rows_(rows), tiles_((cols + kTileColumns - 1) / kTileColumns), data_(rows * tiles_ * kTileColumns) {}
  std::size_t rows() const { return rows_; }
  std::size_t tiles() const { return tiles_; }
  double* at(std::size_t tile, std::size_t row) { return data_.data() + (tile * rows_ + row) * kTileColumns; }
  const double* at(std::size_t tile, std::size_t row) const {
    return data_.data() + (tile * rows_ + row) * kTileColumns;
  }

 private:
  std::size_t rows_, tiles_;
  std::vector<double> data_;
};

/// One row of input, with radius zeros before it and enough zeros behind it for whole tiles.
std::vector<double> padded_row(std::size_t cols, std::size_t radius);

/// Row pass: out_m[i] = Σ_t moment(m)[t]·padded[i + t] for the first `moments` moments (2 or 3) of one row,
/// written to row `row` of each out_m; padded is laid out as padded_row() says.
/// Only the tiles in [tile_begin, tile_end) are computed.
void pass_along_row(const double* padded, const GaussianTaps& taps, std::size_t row, std::size_t tile_begin,
                    std::size_t tile_end, std::size_t moments, TiledRows* const* out);

/// Rows that pass_across_rows handles at a time.
constexpr std::size_t kBlockRows = 4;
using TileBlock = double[kBlockRows][kTileColumns];

/// Column pass: out_m[r][i] = Σ_t moment(first + m)[t]·in(tile, row + r + t − radius, i), m = 0 … moments−1,
/// for kBlockRows rows from `row` on (those past the last row come out meaningless); rows outside the grid
/// count as zero.
void pass_across_rows(const TiledRows& in, const GaussianTaps& taps, std::size_t tile, std::size_t row,
                      std::size_t first, std::size_t moments, TileBlock* out);

}  // namespace micro
