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

namespace detail {
/// Throws InputError unless dx and dy are positive and finite.
void check_pitch(double dx, double dy);
[[noreturn]] void refuse_height_range();
}  // namespace detail

/// Makes a height field of the heights height(k), k = j·cols + i, in µm (NaN or ±inf = missing): removes the
/// mean over valid points in double. `height` is called more than once for each k, so that a reader can
/// convert its samples straight to float. Throws InputError unless dx and dy are positive and finite and the
/// heights fit a float.
template <typename Height>
HeightField sample_height_field(Eigen::Index rows, Eigen::Index cols, double dx, double dy, Height&& height) {
  detail::check_pitch(dx, dy);
  const Eigen::Index count = rows * cols;
  // The first valid height goes first: a plain sum of 76 mm offsets would cost the digits of an 8 nm
  // roughness.
  double first = 0;
  for (Eigen::Index k = 0; k < count; ++k)
    if (const double value = height(k); std::isfinite(value)) {
      first = value;
      break;
    }
  double sum = 0;
  Eigen::Index valid = 0;
  for (Eigen::Index k = 0; k < count; ++k) {
    const double value = height(k);
    const bool there = std::isfinite(value);
    sum += there ? value - first : 0.;
    valid += there;
  }
  HeightField surface{.z = Grid<float>(rows, cols), .dx = dx, .dy = dy};
  surface.mean = valid > 0 ? first + sum / static_cast<double>(valid) : 0;
  if (!std::isfinite(surface.mean)) detail::refuse_height_range();
  float* z = surface.z.data();
  bool fits = true;
  for (Eigen::Index k = 0; k < count; ++k) {
    const double value = height(k) - surface.mean;
    const bool there = std::isfinite(value);
    fits &= !there || std::abs(value) <= std::numeric_limits<float>::max();
    z[k] = there && fits ? static_cast<float>(value) : kMissing;
  }
  if (!fits) detail::refuse_height_range();
  return surface;
}

/// Makes a height field of heights in µm (NaN or ±inf = missing): removes the mean over valid points in
/// double. Throws like sample_height_field.
HeightField make_height_field(const Grid<double>& z, double dx, double dy);

}  // namespace micro
