#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <vector>

#include "core/error.h"
#include "height/repair.h"

namespace micro {
namespace {

struct Neighbour {
  Eigen::Index dj, di;
  double weight;  ///< 1 for the shorter spacing, (shorter/longer)² along the longer
};

std::array<Neighbour, 4> five_point_stencil(const HeightField& surface) {
  const double shorter = std::min(surface.dx, surface.dy);
  const double wx = shorter * shorter / (surface.dx * surface.dx);
  const double wy = shorter * shorter / (surface.dy * surface.dy);
  return {{{0, -1, wx}, {0, 1, wx}, {-1, 0, wy}, {1, 0, wy}}};
}

}  // namespace

Repair fill_holes(const HeightField& surface) {
  const Eigen::Index rows = surface.rows(), cols = surface.cols();
  Repair repair{surface};
  Grid<int> unknown(rows, cols);  // number of each missing point, −1 elsewhere
  int n = 0;
  for (Eigen::Index k = 0; k < surface.z.size(); ++k)
    unknown(k) = is_missing(surface.z(k)) ? n++ : -1;
  if (n == surface.z.size()) throw InputError("holes cannot be filled: no point has a height");
  if (n == 0) return repair;

  // One equation per missing point: Σ w (z − z_neighbour) = 0 over the neighbours inside the image. Every
  // hole touches a valid point, so the matrix is positive definite; separate holes are separate blocks of it.
  const auto stencil = five_point_stencil(surface);
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(5 * static_cast<std::size_t>(n));
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  for (Eigen::Index j = 0; j < rows; ++j)
    for (Eigen::Index i = 0; i < cols; ++i) {
      const int row = unknown(j, i);
      if (row < 0) continue;
      double diagonal = 0;
      for (const Neighbour& to : stencil) {
        const Eigen::Index jj = j + to.dj, ii = i + to.di;
        if (jj < 0 || jj >= rows || ii < 0 || ii >= cols) continue;
        diagonal += to.weight;
        if (unknown(jj, ii) < 0)
          right(row) += to.weight * surface.z(jj, ii);
        else if (unknown(jj, ii) < row)  // the lower triangle is enough
          entries.emplace_back(row, unknown(jj, ii), -to.weight);
      }
      entries.emplace_back(row, row, diagonal);
    }
  Eigen::SparseMatrix<double> laplace(n, n);
  laplace.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(laplace);
  if (solver.info() != Eigen::Success) throw InputError("holes cannot be filled: the pitch is too uneven");
  const Eigen::VectorXd filled = solver.solve(right);

  for (Eigen::Index k = 0; k < surface.z.size(); ++k)
    if (unknown(k) >= 0) repair.surface.z(k) = static_cast<float>(filled(unknown(k)));
  repair.changed = n;
  repair.largest_change = filled.cwiseAbs().maxCoeff();
  return repair;
}

}  // namespace micro
