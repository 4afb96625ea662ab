#pragma once

#include <cstdint>
#include <vector>

#include "core/grid.h"
#include "height/height_field.h"

namespace micro {

/// One row of quadrature points at equal y. Points without any weight have z = 0.
struct LatticeRow {
  std::vector<float> z;       ///< µm
  std::vector<float> area;    ///< µm²: ∫ f dxdy ≈ Σ area·f
  std::vector<float> nx, ny;  ///< µm: ∮ f n dl ≈ Σ (nx, ny)·f over the rim and the edges of holes
  std::vector<int> rim;       ///< indices of points with nx or ny ≠ 0, ascending
};

/// Quadrature of the triangulated surface (height/triangles.h) on a regular lattice `subdivision`·2 times as
/// fine as its grid. Each triangle is cut into subdivision² equal ones, each integrated by the midpoints of
/// its three edges (exact for quadratics); each edge of the rim, holes included, by as many Simpson rules. A
/// missing triangle just does not contribute, so missing data cost no accuracy. A taper (coherence.h) weighs
/// the cells; where neighbours differ, their common edge belongs to the rim with the difference of weights.
class QuadratureLattice {
 public:
  QuadratureLattice(const HeightField& surface, int subdivision, Grid<float> taper = {});

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
  /// Weight of a triangle, 0 where none is.
  float lower(Eigen::Index j, Eigen::Index i) const { return weight(lower_, j, i); }
  float upper(Eigen::Index j, Eigen::Index i) const { return weight(upper_, j, i); }
  float weight(const Grid<std::uint8_t>& cells, Eigen::Index j, Eigen::Index i) const {
    if (j < 0 || i < 0 || j >= cells.rows() || i >= cells.cols() || cells(j, i) == 0) return 0;
    return taper_.size() ? taper_(j, i) : 1;
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
  float third_;  ///< a third of a sub-triangle's area, µm²
  Grid<std::uint8_t> lower_, upper_;
};

/// Fraction of the triangulation's edges that belong to the rim or to a hole's: one triangle is there, the
/// other is not.
double rim_fraction(const HeightField& surface);

}  // namespace micro
