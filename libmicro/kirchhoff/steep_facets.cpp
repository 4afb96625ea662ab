#include "kirchhoff/steep_facets.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"
#include "kirchhoff/gauss_rule.h"

namespace micro {
namespace {

/// The part of a facet from an apex to two corners b and c at one height.
struct HalfFacet {
  Vec3 apex, to_b, along;  ///< along = c − b
  double area2 = 0;        ///< twice its projected area, µm²
  GaussCut outward = {0, 0}, across = {0, 0};
  std::int64_t points() const { return outward.points() * across.points(); }
};

HalfFacet make_half(const Vec3& apex, const Vec3& b, const Vec3& c, const FacetPhases& phases) {
  HalfFacet half{apex, b - apex, c - b};
  half.area2 = std::abs(half.to_b.x() * half.along.y() - half.to_b.y() * half.along.x());
  if (!(half.area2 > 0)) return half;
  const double reach = std::max(half.to_b.head<2>().norm(), (c - apex).head<2>().norm());
  half.outward = gauss_cut(phases.q * (std::abs(half.to_b.z()) + phases.sin_theta * reach), phases.tolerance);
  half.across = gauss_cut(phases.q * phases.sin_theta * half.along.head<2>().norm(), phases.tolerance);
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
  std::vector<GaussNode> outward, across;
};

/// Writes the points of one half, and returns the place after them.
SurfacePoint* write_points(const HalfFacet& half, double weight, Rules& rules, SurfacePoint* to) {
  if (half.points() == 0) return to;
  rules.made.fill(half.outward, rules.outward);
  rules.made.fill(half.across, rules.across);
  for (const GaussNode& t : rules.outward)
    for (const GaussNode& s : rules.across) {
      const Vec3 at = half.apex + t.t * (half.to_b + s.t * half.along);
      *to++ = {at.x(), at.y(), at.z(), static_cast<float>(weight * half.area2 * t.t * t.weight * s.weight)};
    }
  return to;
}

constexpr std::int64_t kFacets = 256;  // handed out together

/// Of points: more than any memory holds.
constexpr std::int64_t kMostCounted = std::int64_t{1} << 50;

}  // namespace

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
  return 2. * gauss_points(0.7 * phases.q * slope * pitch + in_plane, phases.tolerance) *
         gauss_points(in_plane, phases.tolerance);
}

}  // namespace micro
