#include "kirchhoff/steep_facets.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/parallel.h"
#include "height/triangles.h"

namespace micro {
namespace {

struct Node {
  double t, weight;
};

/// The n-point Gauss–Legendre rule on [0, 1]: eigenvalues of the Jacobi matrix and the squares of its
/// eigenvectors' first components [Golub69].
std::vector<Node> gauss_legendre(int n) {
  const Eigen::VectorXd beside = Eigen::VectorXd::NullaryExpr(n - 1, [](Eigen::Index i) {
    const double k = static_cast<double>(i + 1);
    return k / std::sqrt(4 * k * k - 1);
  });
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> jacobi;
  jacobi.computeFromTridiagonal(Eigen::VectorXd::Zero(n), beside);
  std::vector<Node> nodes;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double first = jacobi.eigenvectors()(0, k);
    nodes.push_back({(1 + jacobi.eigenvalues()[k]) / 2, first * first});
  }
  return nodes;
}

/// Rules made so far. Orders go up by an eighth, so that they are few.
class GaussRules {
 public:
  const std::vector<Node>& at_least(int n) {
    int order = 2;
    while (order < n)
      order += std::max(1, order / 8);
    const auto [rule, is_new] = rules_.try_emplace(order);
    if (is_new) rule->second = gauss_legendre(order);
    return rule->second;
  }

 private:
  std::map<int, std::vector<Node>> rules_;
};

/// The triangle from an apex to two corners at one height.
void add_half(const Vec3& apex, const Vec3& b, const Vec3& c, const FacetPhases& phases, double weight,
              GaussRules& rules, std::vector<SurfacePoint>& points) {
  const Vec3 to_b = b - apex, along = c - b;
  const double area2 = std::abs(to_b.x() * along.y() - to_b.y() * along.x());
  if (!(area2 > 0)) return;
  const double reach = std::max(to_b.head<2>().norm(), (c - apex).head<2>().norm());
  const auto& outward =
      rules.at_least(gauss_points(phases.q * (std::abs(to_b.z()) + phases.sin_theta * reach)));
  const auto& across = rules.at_least(gauss_points(phases.q * phases.sin_theta * along.head<2>().norm()));
  for (const Node& t : outward)
    for (const Node& s : across) {
      const Vec3 at = apex + t.t * (to_b + s.t * along);
      points.push_back({at.x(), at.y(), static_cast<float>(at.z()),
                        static_cast<float>(weight * area2 * t.t * t.weight * s.weight)});
    }
}

void add_facet(const QuadratureLattice& lattice, const Triangle& triangle, const FacetPhases& phases,
               GaussRules& rules, std::vector<SurfacePoint>& points) {
  const HeightField& surface = lattice.surface();
  const auto place = [&](const Eigen::Vector2i& at) {
    return Vec3(at.x() * surface.dx, at.y() * surface.dy, surface.z(at.y(), at.x()));
  };
  std::array<Vec3, 3> corner = {place(triangle.a), place(triangle.b), place(triangle.c)};
  std::sort(corner.begin(), corner.end(), [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); });
  const auto& [low, middle, high] = corner;
  Vec3 level = low + (high - low) * ((middle.z() - low.z()) / (high.z() - low.z()));
  level.z() = middle.z();
  const double weight = lattice.cell_weight(triangle.a.y(), triangle.a.x());
  add_half(low, middle, level, phases, weight, rules, points);
  add_half(high, middle, level, phases, weight, rules, points);
}

}  // namespace

int gauss_points(double phase) {
  // Exact to degree 2n − 1; beyond a the Legendre series of e^{iat}, |t| ≤ 1, falls like Bessel functions.
  const double a = phase / 2;
  return static_cast<int>(std::ceil((a + 2.5 * std::cbrt(a) + 4) / 2));
}

std::vector<SurfacePoint> steep_facet_points(const QuadratureLattice& lattice, const FacetPhases& phases) {
  if (!std::isfinite(lattice.steepest())) return {};
  constexpr std::int64_t kRows = 32;
  const HeightField& surface = lattice.surface();
  const std::int64_t cells = surface.rows() - 1;
  std::vector<std::vector<SurfacePoint>> blocks(static_cast<std::size_t>((cells + kRows - 1) / kRows));
  parallel_blocks(cells, kRows, [&](std::int64_t begin, std::int64_t end) {
    GaussRules rules;
    for (std::int64_t j = begin; j < end; ++j)
      for_each_triangle(surface, j, [&](const Triangle& triangle) {
        if (lattice.leaves_out(triangle))
          add_facet(lattice, triangle, phases, rules, blocks[static_cast<std::size_t>(begin / kRows)]);
      });
  });
  std::vector<SurfacePoint> points;
  for (const auto& block : blocks)
    points.insert(points.end(), block.begin(), block.end());
  return points;
}

std::int64_t count_facet_points(const QuadratureLattice& lattice, const FacetPhases& phases) {
  if (!std::isfinite(lattice.steepest())) return 0;
  const HeightField& surface = lattice.surface();
  double count = 0;
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for_each_triangle(surface, j, [&](const Triangle& triangle) {
      if (lattice.leaves_out(triangle))
        count += expected_facet_points(std::hypot(triangle.zx, triangle.zy), std::max(surface.dx, surface.dy),
                                       phases);
    });
  return static_cast<std::int64_t>(count);
}

double expected_facet_points(double slope, double pitch, const FacetPhases& phases) {
  const double in_plane = phases.q * phases.sin_theta * pitch;
  return 2. * gauss_points(0.7 * phases.q * slope * pitch + in_plane) * gauss_points(in_plane);
}

}  // namespace micro
