#include "kirchhoff/subdivision.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "kirchhoff/quadrature_lattice.h"
#include "kirchhoff/spectral_work.h"
#include "kirchhoff/steep_facets.h"

namespace micro {
namespace {

/// Points of steep facets that 300 MB hold, and periods of a lattice beyond which a table is refused anyway.
constexpr double kMostSteepPoints = 3e6;
constexpr int kMostPeriods = 4096;

/// One cell of the relief: slope s = |∇z|, and its change κ from cell to cell (the root of the sum of the
/// squared second differences, per pitch). A facet shines where q_z = |q|·cosθ, cosθ = 1/√(1 + s²): phases go
/// with s·cosθ = sinθ and κ·cosθ. At the foot of a cliff κ is the cliff's: four times its own slope is as
/// much as a cell's own phase can jump by.
struct ReliefCell {
  double slope, sine, kink;  ///< s, sinθ, κ·cosθ
};

/// z(j−dj, i−di) − 2z(j, i) + z(j+dj, i+di), µm; 0 beyond the border or beside a hole: that edge is the
/// rim's.
double second_difference(const HeightField& surface, Eigen::Index j, Eigen::Index i, Eigen::Index dj,
                         Eigen::Index di) {
  if (j < dj || i < di || j + dj >= surface.rows() || i + di >= surface.cols()) return 0;
  const double before = surface.z(j - dj, i - di), after = surface.z(j + dj, i + di);
  const double value = before - 2. * surface.z(j, i) + after;
  return std::isfinite(value) ? value : 0;
}

/// The relief at some 25,000 cells, in ascending order of slope.
std::vector<ReliefCell> sample_relief(const HeightField& surface) {
  constexpr Eigen::Index kSamples = 25000;
  const Eigen::Index step = std::max<Eigen::Index>(1, surface.rows() * surface.cols() / kSamples);
  std::vector<ReliefCell> cells;
  Eigen::Index start = 0;
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for (Eigen::Index i = start++ % step; i + 1 < surface.cols(); i += step) {
      const double z00 = surface.z(j, i), z01 = surface.z(j, i + 1), z10 = surface.z(j + 1, i),
                   z11 = surface.z(j + 1, i + 1);
      const double slope = std::hypot((z01 - z00) / surface.dx, (z11 - z01) / surface.dy);
      if (!std::isfinite(slope)) continue;
      const double twist = z11 - z10 - z01 + z00;
      const double xy = std::isfinite(twist) ? twist / std::sqrt(surface.dx * surface.dy) : 0;
      const double xx = second_difference(surface, j, i, 0, 1) / surface.dx;
      const double yy = second_difference(surface, j, i, 1, 0) / surface.dy;
      const double cosine = 1 / std::sqrt(1 + slope * slope);
      const double kink = std::min(std::sqrt(xx * xx + yy * yy + 2 * xy * xy), 4 * slope);
      cells.push_back({slope, slope * cosine, cosine * kink});
    }
  std::sort(cells.begin(), cells.end(),
            [](const ReliefCell& a, const ReliefCell& b) { return a.slope < b.slope; });
  return cells;
}

/// Sums over the sampled cells that have been sorted by slope, so that any lattice is judged in no time.
class Relief {
 public:
  Relief(const HeightField& surface, const SubdivisionDemands& demands) : cells_(sample_relief(surface)) {
    const double q = demands.phase / std::max(surface.dx, surface.dy);
    const FacetPhases phases = {q, demands.sin_theta};
    const double pitch = std::max(surface.dx, surface.dy);
    double fourth = 0, square = 0, points = 0;
    for (const ReliefCell& cell : cells_) {
      fourth += std::pow(cell.sine, 4) * cell.kink * cell.kink;
      square += cell.kink * cell.kink;
      points += 2 * expected_facet_points(cell.slope, pitch, phases);
      fourth_.push_back(fourth);
      square_.push_back(square);
      points_.push_back(points);
    }
  }

  std::size_t size() const { return cells_.size(); }
  double slope(std::size_t n) const { return cells_[n].slope; }
  /// How many cells are not steeper.
  std::size_t up_to(double slope) const {
    return static_cast<std::size_t>(
        std::upper_bound(cells_.begin(), cells_.end(), slope,
                         [](double limit, const ReliefCell& cell) { return limit < cell.slope; }) -
        cells_.begin());
  }
  /// Per axis: the median of sinθ over that of a Rayleigh distribution of σ = 1.
  double typical_sine() const {
    return cells_.empty() ? 0 : cells_[size() / 2].sine / std::sqrt(2 * std::numbers::ln2);
  }
  /// √⟨min(sinθ, limit)⁴ (κ·cosθ)²⟩, where the steepest cells, from `end`, do not count.
  double kinks(double limit, std::size_t end) const {
    if (end == 0) return 0;
    const double slope = limit < 1 ? limit / std::sqrt(1 - limit * limit) : cells_.back().slope;
    const std::size_t middle = std::min(end, up_to(slope));
    const double sum =
        before(fourth_, middle) + std::pow(limit, 4) * (before(square_, end) - before(square_, middle));
    return std::sqrt(sum / static_cast<double>(size()));
  }
  /// The first cell from which on facet_points() is within `most`.
  std::size_t first_within(double most) const {
    const double all = facet_points(0) * static_cast<double>(size());
    const double least = all - most * static_cast<double>(size());
    return static_cast<std::size_t>(std::lower_bound(points_.begin(), points_.end(), least) -
                                    points_.begin()) +
           (least > 0 ? 1 : 0);
  }
  /// Points a cell that integrating the cells from `begin` one by one takes.
  double facet_points(std::size_t begin) const {
    return size() ? (before(points_, size()) - before(points_, begin)) / static_cast<double>(size()) : 0;
  }

 private:
  static double before(const std::vector<double>& sums, std::size_t end) {
    return end == 0 ? 0 : sums[end - 1];
  }
  std::vector<ReliefCell> cells_;
  std::vector<double> fourth_, square_, points_;  ///< sums up to each cell
};

/// The slope s whose phase turns by `turns`·|q| per length in its worst direction on the table:
/// max sinθ + s·cosθ over θ up to the outermost, which is √(1 + s²) where tanθ = 1/s is on the table.
double steepest_slope(double turns, double sin_theta) {
  if (turns * sin_theta >= 1) return std::sqrt(turns * turns - 1);
  return (turns - sin_theta) / std::sqrt(1 - sin_theta * sin_theta);
}

}  // namespace

Subdivision choose_subdivision(const HeightField& surface, const SubdivisionDemands& demands) {
  const double phase = demands.phase, sin_theta = demands.sin_theta, tol = demands.tolerance;
  const Relief relief(surface, demands);

  const double rim = rim_fraction(surface);
  const double dense = 1.7e-2 * rim * rim, far = 2e-3 * (1 + 3 * std::min(1.0, rim / 0.024));
  const double in_plane = std::max(2 * dense / tol, far / (25 * tol));
  const double finest = phase / 2.5 * sin_theta * std::pow(in_plane, 0.25);
  // In-plane phases alone must stay within half a period, whatever that takes.
  const double half_period = phase * sin_theta / std::numbers::pi;
  const int least =
      std::max(std::clamp(static_cast<int>(std::ceil(finest)), 1, kMostSubdivision),
               static_cast<int>(std::min<double>(std::ceil(half_period * (1 - 1e-9)), kMostPeriods)));

  const auto kinked = [&](int n, std::size_t end) {
    constexpr double kKink = 4e-3;
    const double across = phase / n;
    return kKink * std::pow(across, 4) * relief.typical_sine() * relief.kinks(std::numbers::pi / across, end);
  };
  // Multiply-adds a cell and term. So many terms do relief and tolerances commonly take; where they are more,
  // points of facets are a little cheaper than thought.
  constexpr double kTerms = 16;
  const auto lattice_cost = [&](int n) { return 4. * n * n * lattice_point_work(demands.kernel_width); };
  const double point_cost = facet_point_work(demands.kernel_width, kTerms);

  // So few cells have to go that the points of the others fit into memory.
  const double cells = static_cast<double>(surface.rows()) * static_cast<double>(surface.cols());
  const std::size_t fewest = relief.first_within(kMostSteepPoints / cells);
  // Close to a whole period the law of kinks is too kind.
  constexpr double kOfPeriod = 0.7, kOfPeriodInBulk = 0.25;
  // If no lattice will do: the finest, which is refused for its many points.
  Subdivision best{kMostPeriods, fewest < relief.size() ? relief.slope(fewest) : 0};
  double least_cost = std::numeric_limits<double>::infinity();
  for (int n = least; n <= kMostPeriods && lattice_cost(n) < least_cost; ++n) {
    const double limit = steepest_slope(kOfPeriod * 2 * std::numbers::pi * n / phase, sin_theta);
    const std::size_t all = relief.up_to(limit);
    if (all < fewest) continue;
    // Where most is steep, errors may add up coherently.
    const double bulk = kOfPeriodInBulk * 2 * std::numbers::pi * n / phase;
    if (4 * relief.up_to(bulk) < 3 * relief.size() && n < kMostSubdivision) continue;
    std::size_t end = all;
    if (kinked(n, all) > tol / 3) {
      if (kinked(n, fewest) > tol / 3 && n < kMostSubdivision) continue;
      std::size_t too_many = all;
      end = fewest;
      while (too_many - end > 1) {
        const std::size_t middle = (too_many + end) / 2;
        (kinked(n, middle) <= tol / 3 ? end : too_many) = middle;
      }
    }
    const double cost = lattice_cost(n) + point_cost * relief.facet_points(end);
    if (!(cost < least_cost)) continue;
    least_cost = cost;
    best = {n, end == all ? limit : relief.slope(end)};
  }
  return best;
}

}  // namespace micro
