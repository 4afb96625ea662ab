#include "kirchhoff/steep_rim.h"

#include <cmath>

#include "core/parallel.h"
#include "kirchhoff/gauss_rule.h"

namespace micro {
namespace {

Vec3 place(const HeightField& surface, Eigen::Index j, Eigen::Index i) {
  return Vec3(static_cast<double>(i) * surface.dx, static_cast<double>(j) * surface.dy, surface.z(j, i));
}

GaussCut cut_of(const HeightField& surface, const RimEdge& edge, const FacetPhases& phases) {
  const Vec3 along = place(surface, edge.to_j, edge.to_i) - place(surface, edge.j, edge.i);
  const double turn = std::abs(along.z()) + phases.sin_theta * along.head<2>().norm();
  return gauss_cut(phases.q * turn, phases.tolerance);
}

}  // namespace

SteepRim find_steep_rim(const QuadratureLattice& lattice, const FacetPhases& phases) {
  SteepRim rim;
  if (!std::isfinite(lattice.highest())) return rim;
  constexpr std::int64_t kRows = 32;
  const HeightField& surface = lattice.surface();
  const Eigen::Index rows = surface.rows(), cols = surface.cols();
  std::vector<SteepRim> blocks(static_cast<std::size_t>((rows + kRows - 1) / kRows));
  parallel_blocks(rows, kRows, [&](std::int64_t begin, std::int64_t end) {
    SteepRim& block = blocks[static_cast<std::size_t>(begin / kRows)];
    for (Eigen::Index j = begin; j < end; ++j) {
      // Without holes the rim is the border.
      const bool border = !lattice.complete() || j == 0 || j + 1 == rows;
      for (Eigen::Index i = 0; i < cols; i += border ? 1 : cols - 1)
        for (const RimEdge& edge : lattice.edges(j, i)) {
          if ((edge.nx == 0 && edge.ny == 0) || !lattice.leaves_out(edge)) continue;
          block.edges.push_back(edge);
          block.points += cut_of(surface, edge, phases).points() * ((edge.nx != 0) + (edge.ny != 0));
        }
    }
  });
  for (const SteepRim& block : blocks) {
    rim.edges.insert(rim.edges.end(), block.edges.begin(), block.edges.end());
    rim.points += block.points;
  }
  return rim;
}

std::array<std::vector<SurfacePoint>, 2> rim_points(const QuadratureLattice& lattice, const SteepRim& rim,
                                                    const FacetPhases& phases) {
  const HeightField& surface = lattice.surface();
  std::array<std::vector<SurfacePoint>, 2> points;
  GaussRules rules;
  std::vector<GaussNode> nodes;
  for (const RimEdge& edge : rim.edges) {
    rules.fill(cut_of(surface, edge, phases), nodes);
    const Vec3 from = place(surface, edge.j, edge.i), along = place(surface, edge.to_j, edge.to_i) - from;
    const float n[2] = {edge.nx, edge.ny};
    for (int axis = 0; axis < 2; ++axis) {
      if (n[axis] == 0) continue;
      for (const GaussNode& node : nodes) {
        const Vec3 at = from + node.t * along;
        points[axis].push_back({at.x(), at.y(), at.z(), n[axis] * static_cast<float>(node.weight)});
      }
    }
  }
  return points;
}

}  // namespace micro
