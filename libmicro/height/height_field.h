#pragma once

#include <cmath>
#include <limits>

#include "core/grid.h"

namespace micro {

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

/// A measured or made surface z(x, y): rows × cols heights on a regular grid.
/// Row j runs along y, column i along x, in the file's own order; nothing is ever flipped.
/// Heights are kept as float after their mean has been removed in double, so that a large offset costs no
/// digits.
struct HeightField {
  Grid<float> z;    ///< [rows, cols] µm, minus `mean`; NaN = missing
  double dx = 0;    ///< µm between columns
  double dy = 0;    ///< µm between rows
  double mean = 0;  ///< µm, the mean over valid points as the surface came in

  Eigen::Index rows() const { return z.rows(); }
  Eigen::Index cols() const { return z.cols(); }
};

inline bool is_missing(float z) {
  return std::isnan(z);
}

/// Number of points without a height.
Eigen::Index missing_count(const HeightField& surface);

/// Makes a height field of heights in µm (NaN or ±inf = missing): removes the mean over valid points in
/// double. Throws InputError unless dx and dy are positive and finite.
HeightField make_height_field(const Grid<double>& z, double dx, double dy);

}  // namespace micro
