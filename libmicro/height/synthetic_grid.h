#pragma once

#include <cstdint>
#include <functional>

#include "height/height_field.h"

namespace micro {

/// Whether a made surface continues at its opposite border: then it has the periods cols·dx and rows·dy.
enum class Border { Open, Periodic };

/// Size and pitch of a surface to make. Making one takes 12 bytes a point, unless its maker says more.
struct SyntheticGrid {
  Eigen::Index rows = 480;
  Eigen::Index cols = 640;
  double dx = 0.11;  ///< µm
  double dy = 0.11;  ///< µm

  double width() const { return static_cast<double>(cols) * dx; }   ///< period along x, µm
  double height() const { return static_cast<double>(rows) * dy; }  ///< period along y, µm
};

/// Throws InputError unless the grid has at least one point and a positive, finite pitch.
void check(const SyntheticGrid& grid);

/// The surface whose height at row j, column i is z(j, i), µm, computed on all threads.
HeightField sample_heights(const SyntheticGrid& grid,
                           const std::function<double(Eigen::Index j, Eigen::Index i)>& z);

}  // namespace micro
