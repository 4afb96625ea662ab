#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace micro {

/// Columns of a strip: what one call of the passes below works on.
constexpr std::size_t kStripColumns = 32;

/// The one-dimensional weights of a Gaussian window and its first moments, sampled at the grid's pitch and
/// cut off at ±radius samples: with x = (t − radius)·pitch/σ,
///   moment(m)[t] = x^m exp(−x²/2),  m = 0, 1, 2,  t = 0 … 2·radius.
/// Each row carries kPad zeros on both sides, so that all outputs of a strip can share one loop over the
/// input.
class GaussianTaps {
 public:
  static constexpr std::size_t kPad = kStripColumns;

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

/// rows × kStripColumns doubles, not set to anything at first.
class Strip {
 public:
  explicit Strip(std::size_t rows) : rows_(rows), data_(new double[rows * kStripColumns]) {}
  std::size_t rows() const { return rows_; }
  double* at(std::size_t row) { return data_.get() + row * kStripColumns; }
  const double* at(std::size_t row) const { return data_.get() + row * kStripColumns; }

 private:
  std::size_t rows_;
  std::unique_ptr<double[]> data_;
};

/// Row pass: out_m[i] = Σ_t moment(m)[t]·values[i + t], m = 0, 1, i < kStripColumns, of the
/// kStripColumns + 2·radius values that begin radius columns before the strip.
void pass_along_row(const double* values, const GaussianTaps& taps, double* const (&out)[2]);

/// Row pass over few points: out_m[i] += factor·Σ_p moment(m)[p − i], m = 0, 1, 2, for the points `places`,
/// counted from radius columns before the strip.
void add_along_row(const std::vector<std::size_t>& places, double factor, const GaussianTaps& taps,
                   double* const (&out)[3]);

/// Rows that pass_across_rows handles at a time.
constexpr std::size_t kBlockRows = 4;
using StripBlock = double[kBlockRows][kStripColumns];

/// Column pass: out_m[r][i] = Σ_t moment(first + m)[t]·in(row + r + t − radius, i), m = 0 … moments−1, for
/// kBlockRows rows from `row` on (those past the last row come out meaningless); rows outside the strip count
/// as zero.
void pass_across_rows(const Strip& in, const GaussianTaps& taps, std::size_t row, std::size_t first,
                      std::size_t moments, StripBlock* out);

}  // namespace micro
