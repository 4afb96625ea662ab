#pragma once

#include <cstdint>

#include "height/height_field.h"

namespace micro {

/// One triangle of the surface: grid coordinates of its corners, anticlockwise seen from +z (x along columns,
/// y along rows), and its slopes ∂z/∂x, ∂z/∂y.
struct Triangle {
  Eigen::Vector2i a, b, c;  ///< (i, j) = (column, row) of each corner
  double zx, zy;            ///< slopes
};

/// The one triangulation that every integral uses: two triangles per cell, cut along the diagonal from (j, i)
/// to (j+1, i+1). The *lower* triangle has corners (j, i), (j, i+1), (j+1, i+1), the *upper* one (j, i),
/// (j+1, i+1), (j+1, i). A triangle with a missing corner is not part of the surface. Calls visit(Triangle)
/// for each triangle of row of cells j, 0 ≤ j < rows−1, in order.
template <typename Visit>
void for_each_triangle(const HeightField& surface, Eigen::Index j, Visit&& visit) {
  const int row = static_cast<int>(j);
  const float* z0 = &surface.z(j, 0);
  const float* z1 = &surface.z(j + 1, 0);
  for (int i = 0; i + 1 < static_cast<int>(surface.cols()); ++i) {
    const double z00 = z0[i], z01 = z0[i + 1], z10 = z1[i], z11 = z1[i + 1];
    const bool diagonal = !std::isnan(z00) && !std::isnan(z11);
    if (diagonal && !std::isnan(z01))
      visit(Triangle{
          {i, row}, {i + 1, row}, {i + 1, row + 1}, (z01 - z00) / surface.dx, (z11 - z01) / surface.dy});
    if (diagonal && !std::isnan(z10))
      visit(Triangle{
          {i, row}, {i + 1, row + 1}, {i, row + 1}, (z11 - z10) / surface.dx, (z10 - z00) / surface.dy});
  }
}

/// Number of triangles that are there.
std::int64_t triangle_count(const HeightField& surface);

/// A_perp, the projected area of the triangles that are there, µm².
double projected_area(const HeightField& surface);

}  // namespace micro
