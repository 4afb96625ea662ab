#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/grid.h"
#include "height/height_field.h"
#include "height/triangles.h"

namespace micro {

/// One row of quadrature points at equal y. Points without any weight have z = 0.
struct LatticeRow {
  std::vector<double> z;      ///< µm
  std::vector<float> area;    ///< µm²: ∫ f dxdy ≈ Σ area·f
  std::vector<float> nx, ny;  ///< µm: ∮ f n dl ≈ Σ (nx, ny)·f over the rim and the edges of holes
  std::vector<int> rim;       ///< indices of points with nx or ny ≠ 0, ascending
};

/// One quadrature point anywhere on the surface.
struct SurfacePoint {
  double x, y, z;  ///< µm
  float weight;    ///< µm² of area, µm along a rim
};

/// An edge of the triangulation from one vertex to a neighbour, and its part in integrals along rims.
struct RimEdge {
  Eigen::Index j, i, to_j, to_i;  ///< rows and columns of its ends
  float nx, ny;  ///< µm: its normal, as long as the edge, out of a cell of weight 1; 0 where neither cell is
                 ///< there or both weigh the same
};

/// Quadrature of the triangulated surface (height/triangles.h) on a regular lattice `subdivision`·2 times as
/// fine as its grid. Each triangle is cut into subdivision² equal ones, each integrated by the midpoints of
/// its three edges (exact for quadratics); each edge of the rim, holes included, by as many Simpson rules. A
/// missing triangle just does not contribute, so missing data cost no accuracy. A taper (coherence.h) weighs
/// the cells; where neighbours differ, their common edge belongs to the rim with the difference of weights.
/// What turns too fast for the lattice is left out: from the area triangles steeper than `steepest`
/// (steep_facets.h has them), from the rim edges that rise by more than `highest` (steep_rim.h).
class QuadratureLattice {
 public:
  QuadratureLattice(const HeightField& surface, int subdivision, Grid<float> taper = {},
                    double steepest = std::numeric_limits<double>::infinity(),
                    double highest = std::numeric_limits<double>::infinity());

  const HeightField& surface() const { return surface_; }
  double steepest() const { return steepest_; }  ///< slope
  double highest() const { return highest_; }    ///< µm
  bool leaves_out(const Triangle& triangle) const {
    return triangle.zx * triangle.zx + triangle.zy * triangle.zy > steepest_ * steepest_;
  }
  bool leaves_out(const RimEdge& edge) const {
    return std::abs(surface_.z(edge.to_j, edge.to_i) - surface_.z(edge.j, edge.i)) > highest_;
  }
  /// The three edges that begin at a vertex: along the row, along the column, diagonal.
  std::array<RimEdge, 3> edges(Eigen::Index j, Eigen::Index i) const;
  /// The taper at a cell's triangles.
  float cell_weight(Eigen::Index j, Eigen::Index i) const { return taper_.size() ? taper_(j, i) : 1; }
  int refinement() const { return refinement_; }  ///< lattice points per grid pitch
  std::int64_t rows() const { return (surface_.rows() - 1) * refinement_ + 1; }
  std::int64_t cols() const { return (surface_.cols() - 1) * refinement_ + 1; }
  double dx() const { return surface_.dx / refinement_; }
  double dy() const { return surface_.dy / refinement_; }
  bool complete() const { return complete_; }  ///< all triangles are there, with weight 1

  /// Even rows (of sub-vertices) carry area only on odd columns.
  static bool area_on_odd_columns_only(std::int64_t row) { return row % 2 == 0; }

  /// Row l of the lattice, 0 ≤ l < rows(); reuses the memory of `row`.
  void fill(std::int64_t l, LatticeRow& row) const;

 private:
  void fill_vertex_row(Eigen::Index j, LatticeRow& row) const;
  void fill_inner_row(Eigen::Index j, int b, LatticeRow& row) const;
  /// What is known of a triangle.
  enum State : std::uint8_t { kMissingTriangle = 0, kGentle = 1, kSteep = 2 };
  /// What edges (j, i) → (j, i+1), (j+1, i) and (j+1, i+1) count with, of normals along y, x and (x, −y): the
  /// difference of the weights on either side.
  float row_edge(Eigen::Index j, Eigen::Index i) const { return upper(j - 1, i) - lower(j, i); }
  float column_edge(Eigen::Index j, Eigen::Index i) const { return lower(j, i - 1) - upper(j, i); }
  float diagonal_edge(Eigen::Index j, Eigen::Index i) const { return upper(j, i) - lower(j, i); }
  /// The same, 0 where the edge is left out.
  float kept(float weight, Eigen::Index j, Eigen::Index i, Eigen::Index to_j, Eigen::Index to_i) const {
    return weight == 0 || leaves_out(RimEdge{j, i, to_j, to_i, 0, 0}) ? 0 : weight;
  }
  float kept_row_edge(Eigen::Index j, Eigen::Index i) const { return kept(row_edge(j, i), j, i, j, i + 1); }
  float kept_column_edge(Eigen::Index j, Eigen::Index i) const {
    return kept(column_edge(j, i), j, i, j + 1, i);
  }
  float kept_diagonal_edge(Eigen::Index j, Eigen::Index i) const {
    return kept(diagonal_edge(j, i), j, i, j + 1, i + 1);
  }
  /// Weight of a triangle, 0 where none is.
  float lower(Eigen::Index j, Eigen::Index i) const { return weight(lower_, j, i); }
  float upper(Eigen::Index j, Eigen::Index i) const { return weight(upper_, j, i); }
  float weight(const Grid<std::uint8_t>& cells, Eigen::Index j, Eigen::Index i) const {
    if (j < 0 || i < 0 || j >= cells.rows() || i >= cells.cols() || cells(j, i) == 0) return 0;
    return cell_weight(j, i);
  }
  /// Weight of a triangle's area.
  float lower_area(Eigen::Index j, Eigen::Index i) const { return area_weight(lower_, j, i); }
  float upper_area(Eigen::Index j, Eigen::Index i) const { return area_weight(upper_, j, i); }
  float area_weight(const Grid<std::uint8_t>& cells, Eigen::Index j, Eigen::Index i) const {
    const float all = weight(cells, j, i);
    return all != 0 && cells(j, i) == kSteep ? 0 : all;
  }
  /// Simpson's weight of the t-th of refinement_+1 points along an edge, of a sum of 1.
  float simpson(int t) const {
    const int weight = t == 0 || t == refinement_ ? 1 : t % 2 == 1 ? 4 : 2;
    return static_cast<float>(weight) / static_cast<float>(3 * refinement_);
  }

  const HeightField& surface_;
  Grid<float> taper_;  ///< of the cells; 0×0: 1
  int refinement_;
  bool complete_;
  double steepest_, highest_;
  float third_;  ///< a third of a sub-triangle's area, µm²
  Grid<std::uint8_t> lower_, upper_;
};

/// Fraction of the triangulation's edges that belong to the rim or to a hole's: one triangle is there, the
/// other is not.
double rim_fraction(const HeightField& surface);

}  // namespace micro
