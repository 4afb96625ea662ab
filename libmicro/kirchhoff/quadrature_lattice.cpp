#include "kirchhoff/quadrature_lattice.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "height/triangles.h"

namespace micro {

QuadratureLattice::QuadratureLattice(const HeightField& surface, int subdivision, Grid<float> taper,
                                     double steepest, double highest)
    : surface_(surface),
      taper_(std::move(taper)),
      refinement_(2 * subdivision),
      steepest_(steepest),
      highest_(highest),
      third_(static_cast<float>(surface.dx * surface.dy / 2 / subdivision / subdivision / 3)),
      lower_(Grid<std::uint8_t>::Zero(surface.rows() - 1, surface.cols() - 1)),
      upper_(lower_) {
  assert(surface.rows() >= 2 && surface.cols() >= 2 && subdivision >= 1);
  assert(taper_.size() == 0 || (taper_.rows() == lower_.rows() && taper_.cols() == lower_.cols()));
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for_each_triangle(surface, j, [&](const Triangle& triangle) {
      const bool is_lower = triangle.b.y() == triangle.a.y();
      (is_lower ? lower_ : upper_)(j, triangle.a.x()) = leaves_out(triangle) ? kSteep : kGentle;
    });
  complete_ = taper_.size() == 0 && (lower_ != 0).all() && (upper_ != 0).all();
}

std::array<RimEdge, 3> QuadratureLattice::edges(Eigen::Index j, Eigen::Index i) const {
  const auto dx = static_cast<float>(surface_.dx), dy = static_cast<float>(surface_.dy);
  const float diagonal = diagonal_edge(j, i);
  return {RimEdge{j, i, j, i + 1, 0, row_edge(j, i) * dx},
          {j, i, j + 1, i, column_edge(j, i) * dy, 0},
          {j, i, j + 1, i + 1, diagonal * dy, -diagonal * dx}};
}

void QuadratureLattice::fill(std::int64_t l, LatticeRow& row) const {
  const auto n = static_cast<std::size_t>(cols());
  row.z.assign(n, 0);
  row.area.assign(n, 0);
  row.nx.assign(n, 0);
  row.ny.assign(n, 0);
  row.rim.clear();
  const auto j = static_cast<Eigen::Index>(l / refinement_);
  const int b = static_cast<int>(l % refinement_);
  if (b == 0)
    fill_vertex_row(j, row);
  else
    fill_inner_row(j, b, row);
  for (int x = 0; x < static_cast<int>(n); ++x)
    if (row.nx[x] != 0 || row.ny[x] != 0) row.rim.push_back(x);
}

void QuadratureLattice::fill_vertex_row(Eigen::Index j, LatticeRow& row) const {
  const auto dx = static_cast<float>(surface_.dx), dy = static_cast<float>(surface_.dy);
  const int r = refinement_;
  const float* z = &surface_.z(j, 0);
  // Along the horizontal edges: the triangle above is a lower one, the one below an upper one.
  for (Eigen::Index i = 0; i + 1 < surface_.cols(); ++i) {
    const float above = lower(j, i), below = upper(j - 1, i);
    const float area = (lower_area(j, i) + upper_area(j - 1, i)) * third_;
    if (above == 0 && below == 0) continue;
    const float rim = kept_row_edge(j, i);
    for (int a = 1; a < r; ++a) {
      const double t = static_cast<double>(a) / r;
      row.z[i * r + a] = z[i] + t * (static_cast<double>(z[i + 1]) - z[i]);
      if (a % 2 == 1) row.area[i * r + a] = area;
    }
    if (rim != 0)
      for (int a = 0; a <= r; ++a)
        row.ny[i * r + a] += rim * dx * simpson(a);
  }
  // At the vertices: ends of the vertical and diagonal edges of the rim that meet there.
  const float end = simpson(0);
  for (Eigen::Index i = 0; i < surface_.cols(); ++i) {
    for (const Eigen::Index cell : {j, j - 1}) {
      const float column = kept_column_edge(cell, i);
      const float diagonal = kept_diagonal_edge(cell, cell == j ? i : i - 1);
      row.nx[i * r] += (column + diagonal) * dy * end;
      row.ny[i * r] -= diagonal * dx * end;
    }
    if (row.nx[i * r] != 0 || row.ny[i * r] != 0) row.z[i * r] = z[i];
  }
}

void QuadratureLattice::fill_inner_row(Eigen::Index j, int b, LatticeRow& row) const {
  const auto dx = static_cast<float>(surface_.dx), dy = static_cast<float>(surface_.dy);
  const int r = refinement_;
  const double v = static_cast<double>(b) / r;
  const float* row0 = &surface_.z(j, 0);
  const float* row1 = &surface_.z(j + 1, 0);
  const auto z0 = [row0](Eigen::Index i) { return static_cast<double>(row0[i]); };
  const auto z1 = [row1](Eigen::Index i) { return static_cast<double>(row1[i]); };
  const float along = simpson(b);
  for (Eigen::Index i = 0; i < surface_.cols(); ++i) {
    const float right = upper(j, i), left = lower(j, i - 1);
    if (right > 0 || left > 0) {
      row.z[i * r] = z0(i) + v * (z1(i) - z0(i));
      if (b % 2 == 1) row.area[i * r] = (upper_area(j, i) + lower_area(j, i - 1)) * third_;
      row.nx[i * r] = kept_column_edge(j, i) * dy * along;
    }
    const float under = lower(j, i), over = upper(j, i);
    const float under_area = lower_area(j, i) * third_, over_area = upper_area(j, i) * third_;
    if (under == 0 && over == 0) continue;
    row.z[i * r + b] = z0(i) + v * (z1(i + 1) - z0(i));
    if (b % 2 == 1) row.area[i * r + b] = under_area + over_area;
    const float diagonal = kept_diagonal_edge(j, i);
    row.nx[i * r + b] = diagonal * dy * along;
    row.ny[i * r + b] = -diagonal * dx * along;
    if (r == 2) continue;
    if (over_area > 0)
      for (int a = 1; a < b; ++a) {
        const double u = static_cast<double>(a) / r;
        row.z[i * r + a] = z0(i) + v * (z1(i) - z0(i)) + u * (z1(i + 1) - z1(i));
        if (a % 2 == 1 || b % 2 == 1) row.area[i * r + a] = 2 * over_area;
      }
    if (under_area > 0)
      for (int a = b + 1; a < r; ++a) {
        const double u = static_cast<double>(a) / r;
        row.z[i * r + a] = z0(i) + u * (z0(i + 1) - z0(i)) + v * (z1(i + 1) - z0(i + 1));
        if (a % 2 == 1 || b % 2 == 1) row.area[i * r + a] = 2 * under_area;
      }
  }
}

double rim_fraction(const HeightField& surface) {
  std::int64_t triangles = 0, shared = 0;
  const auto there = [&](Eigen::Index j, Eigen::Index i) { return !is_missing(surface.z(j, i)); };
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for (Eigen::Index i = 0; i + 1 < surface.cols(); ++i) {
      const bool diagonal = there(j, i) && there(j + 1, i + 1);
      const bool lower = diagonal && there(j, i + 1), upper = diagonal && there(j + 1, i);
      triangles += lower + upper;
      shared += lower && upper;
      // Across the lower triangle's vertical edge lies the next cell's upper one; across the upper triangle's
      // horizontal edge, the lower one of the cell above. Each shares two corners and needs a third.
      if (lower && i + 2 < surface.cols()) shared += there(j + 1, i + 2);
      if (upper && j + 2 < surface.rows()) shared += there(j + 2, i + 1);
    }
  const std::int64_t edges = 3 * triangles - shared;
  return edges > 0 ? static_cast<double>(edges - shared) / static_cast<double>(edges) : 0;
}

}  // namespace micro
