#include "kirchhoff/steep_facets.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/parallel.h"

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

/// How an interval is cut: panels of equal length, each with a Gauss–Legendre rule of this order. A rule's
/// making takes the cube of its order, and beyond 200 rad longer panels hardly save points.
struct Cut {
  std::int64_t panels;
  int order;
  std::int64_t points() const { return panels * order; }
};

Cut cut_for(double phase) {
  constexpr double kPanelPhase = 200, kMostPanels = 1e5;  // of metres
  const double panels = std::clamp(std::ceil(phase / kPanelPhase), 1., kMostPanels);
  const int wanted = gauss_points(std::min(phase / panels, kPanelPhase));
  // Orders go up by an eighth, so that they are few.
  int order = 2;
  while (order < wanted)
    order += std::max(1, order / 8);
  return {static_cast<std::int64_t>(panels), order};
}

/// Rules made so far.
class GaussRules {
 public:
  /// The composite rule on [0, 1].
  void fill(const Cut& cut, std::vector<Node>& nodes) {
    const auto [rule, is_new] = rules_.try_emplace(cut.order);
    if (is_new) rule->second = gauss_legendre(cut.order);
    nodes.clear();
    const auto panels = static_cast<double>(cut.panels);
    for (double p = 0; p < panels; ++p)
      for (const Node& node : rule->second)
        nodes.push_back({(p + node.t) / panels, node.weight / panels});
  }

 private:
  std::map<int, std::vector<Node>> rules_;
};

/// The part of a facet from an apex to two corners b and c at one height.
struct HalfFacet {
  Vec3 apex, to_b, along;  ///< along = c − b
  double area2 = 0;        ///< twice its projected area, µm²
  Cut outward = {0, 0}, across = {0, 0};
  std::int64_t points() const { return outward.points() * across.points(); }
};

HalfFacet make_half(const Vec3& apex, const Vec3& b, const Vec3& c, const FacetPhases& phases) {
  HalfFacet half{apex, b - apex, c - b};
  half.area2 = std::abs(half.to_b.x() * half.along.y() - half.to_b.y() * half.along.x());
  if (!(half.area2 > 0)) return half;
  const double reach = std::max(half.to_b.head<2>().norm(), (c - apex).head<2>().norm());
  half.outward = cut_for(phases.q * (std::abs(half.to_b.z()) + phases.sin_theta * reach));
  half.across = cut_for(phases.q * phases.sin_theta * half.along.head<2>().norm());
  return half;
}

std::array<HalfFacet, 2> halves_of(const HeightField& surface, const Triangle& facet,
                                   const FacetPhases& phases) {
  const auto place = [&](const Eigen::Vector2i& at) {
    return Vec3(at.x() * surface.dx, at.y() * surface.dy, surface.z(at.y(), at.x()));
  };
  std::array<Vec3, 3> corner = {place(facet.a), place(facet.b), place(facet.c)};
  std::sort(corner.begin(), corner.end(), [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); });
  const auto& [low, middle, high] = corner;
  Vec3 level = low + (high - low) * ((middle.z() - low.z()) / (high.z() - low.z()));
  level.z() = middle.z();
  return {make_half(low, middle, level, phases), make_half(high, middle, level, phases)};
}

/// Memory that one half's rules take.
struct Rules {
  GaussRules made;
  std::vector<Node> outward, across;
};

/// Writes the points of one half, and returns the place after them.
SurfacePoint* write_points(const HalfFacet& half, double weight, Rules& rules, SurfacePoint* to) {
  if (half.points() == 0) return to;
  rules.made.fill(half.outward, rules.outward);
  rules.made.fill(half.across, rules.across);
  for (const Node& t : rules.outward)
    for (const Node& s : rules.across) {
      const Vec3 at = half.apex + t.t * (half.to_b + s.t * half.along);
      *to++ = {at.x(), at.y(), static_cast<float>(at.z()),
               static_cast<float>(weight * half.area2 * t.t * t.weight * s.weight)};
    }
  return to;
}

constexpr std::int64_t kFacets = 256;  // handed out together

/// Of points: more than any memory holds.
constexpr std::int64_t kMostCounted = std::int64_t{1} << 50;

}  // namespace

int gauss_points(double phase) {
  // Exact to degree 2n − 1; beyond a the Legendre series of e^{iat}, |t| ≤ 1, falls like Bessel functions.
  const double a = phase / 2;
  constexpr double kMost = 1e9;
  return static_cast<int>(std::min(std::ceil((a + 2.5 * std::cbrt(a) + 4) / 2), kMost));
}

SteepFacets find_steep_facets(const QuadratureLattice& lattice, const FacetPhases& phases) {
  if (!std::isfinite(lattice.steepest())) return {{}, {0}};
  constexpr std::int64_t kRows = 32;
  const HeightField& surface = lattice.surface();
  const std::int64_t cells = surface.rows() - 1;
  std::vector<SteepFacets> blocks(static_cast<std::size_t>((cells + kRows - 1) / kRows));
  parallel_blocks(cells, kRows, [&](std::int64_t begin, std::int64_t end) {
    SteepFacets& block = blocks[static_cast<std::size_t>(begin / kRows)];
    for (std::int64_t j = begin; j < end; ++j)
      for_each_triangle(surface, j, [&](const Triangle& triangle) {
        if (!lattice.leaves_out(triangle)) return;
        std::int64_t points = 0;
        for (const HalfFacet& half : halves_of(surface, triangle, phases))
          points += half.points();
        block.facets.push_back(triangle);
        block.first_point.push_back(points);
      });
  });
  SteepFacets steep{{}, {0}};
  for (const SteepFacets& block : blocks) {
    steep.facets.insert(steep.facets.end(), block.facets.begin(), block.facets.end());
    for (const std::int64_t points : block.first_point)
      steep.first_point.push_back(std::min(steep.first_point.back() + points, kMostCounted));
  }
  return steep;
}

std::vector<SurfacePoint> facet_points(const QuadratureLattice& lattice, const SteepFacets& steep,
                                       const FacetPhases& phases) {
  std::vector<SurfacePoint> points(static_cast<std::size_t>(steep.points()));
  parallel_blocks(static_cast<std::int64_t>(steep.facets.size()), kFacets,
                  [&](std::int64_t begin, std::int64_t end) {
                    Rules rules;
                    SurfacePoint* to = points.data() + steep.first_point[static_cast<std::size_t>(begin)];
                    for (std::int64_t n = begin; n < end; ++n) {
                      const Triangle& facet = steep.facets[static_cast<std::size_t>(n)];
                      const double weight = lattice.cell_weight(facet.a.y(), facet.a.x());
                      for (const HalfFacet& half : halves_of(lattice.surface(), facet, phases))
                        to = write_points(half, weight, rules, to);
                    }
                  });
  return points;
}

double expected_facet_points(double slope, double pitch, const FacetPhases& phases) {
  const double in_plane = phases.q * phases.sin_theta * pitch;
  // A half's height is the facet's times the cut's place: 0.7 of it goes into the longer one, about.
  return 2. * gauss_points(0.7 * phases.q * slope * pitch + in_plane) * gauss_points(in_plane);
}

}  // namespace micro
