#include "height/brushed_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"

namespace micro {
namespace {

constexpr double kLargestFactor = 1.5;  // of a scratch's size over the mean
constexpr double kMostScratches = 1e7;
constexpr Eigen::Index kRowsPerBlock = 16;
/// ∫(1 − t²)⁴ dt over (−1, 1), of the squared profile in one direction.
constexpr double kProfileSquared = 256. / 315;

struct Scratch {
  double x, y, cos, sin;  ///< centre, µm, and direction
  double a, b, depth;     ///< half length, half width, µm
};

/// Scratches per µm².
double density(const Brushing& brushing) {
  return brushing.coverage / (brushing.length * brushing.width);
}

/// Rectangle around the origin, turned by an angle, in which the centres fall.
struct Field {
  double x, y, cos, sin;  ///< its centre, µm, and the direction of its length
  double length, width;
};

Field field_of_centres(const SyntheticGrid& grid, const Brushing& brushing, Border border) {
  if (border == Border::Periodic)
    return {grid.width() / 2, grid.height() / 2, 1, 0, grid.width(), grid.height()};
  const double c = std::cos(brushing.orientation), s = std::sin(brushing.orientation);
  const double a = kLargestFactor * brushing.length / 2, b = kLargestFactor * brushing.width / 2;
  const double tilt = std::sin(brushing.spread);
  return {grid.width() / 2,
          grid.height() / 2,
          c,
          s,
          grid.width() * std::abs(c) + grid.height() * std::abs(s) + 2 * (a + b * tilt),
          grid.width() * std::abs(s) + grid.height() * std::abs(c) + 2 * (b + a * tilt)};
}

/// A Poisson process on the rectangle: exponential steps across it, uniform along it.
std::vector<Scratch> draw_scratches(const Field& field, const Brushing& brushing, std::uint64_t seed) {
  const double per_step = density(brushing) * field.length;  // scratches per µm of width
  if (!(per_step * field.width < kMostScratches))
    throw InputError("this brushing needs more than 10 million scratches; ask for fewer or larger ones");
  enum Stream : std::uint32_t { kPlace, kSize, kLie };
  std::vector<Scratch> scratches;
  const double mean = mean_depth(brushing);
  double v = 0;
  for (std::uint64_t k = 0;; ++k) {
    const auto place = random_uniform(seed, kPlace, k);
    v -= std::log(place[0]) / per_step;
    if (v >= field.width) return scratches;
    const auto size = random_uniform(seed, kSize, k), lie = random_uniform(seed, kLie, k);
    const double along = (place[1] - 0.5) * field.length, across = v - 0.5 * field.width;
    const double angle = brushing.orientation + (2 * lie[0] - 1) * brushing.spread;
    Scratch scratch{};
    scratch.x = field.x + along * field.cos - across * field.sin;
    scratch.y = field.y + along * field.sin + across * field.cos;
    scratch.cos = std::cos(angle);
    scratch.sin = std::sin(angle);
    scratch.a = brushing.length / 2 * (0.5 + size[0]);
    scratch.b = brushing.width / 2 * (0.5 + size[1]);
    scratch.depth = -mean * std::log(lie[1]);
    scratches.push_back(scratch);
  }
}

/// The numbers t with |p + q t| < r, as an interval.
struct Interval {
  double low, high;
};

Interval where_within(double p, double q, double r) {
  constexpr double kEverywhere = 1e300;
  if (q == 0) return std::abs(p) < r ? Interval{-kEverywhere, kEverywhere} : Interval{1, 0};
  const double t0 = (-r - p) / q, t1 = (r - p) / q;
  return {std::min(t0, t1), std::max(t0, t1)};
}

std::int64_t wrap(std::int64_t i, std::int64_t n) {
  return ((i % n) + n) % n;
}

double bell(double t) {
  const double s = 1 - t * t;
  return s * s;
}

/// Adds what a scratch takes from row j (any j: beyond the surface it may be an image of one inside).
void engrave_row(const Scratch& scratch, const SyntheticGrid& grid, Border border, Eigen::Index j,
                 double* row) {
  const double y = static_cast<double>(j) * grid.dy - scratch.y;
  const auto u = [&](double x) { return (x - scratch.x) * scratch.cos + y * scratch.sin; };
  const auto v = [&](double x) { return -(x - scratch.x) * scratch.sin + y * scratch.cos; };
  const Interval along = where_within(u(0), scratch.cos, scratch.a);
  const Interval across = where_within(v(0), -scratch.sin, scratch.b);
  double low = std::max(along.low, across.low) / grid.dx, high = std::min(along.high, across.high) / grid.dx;
  if (border == Border::Open)
    low = std::max(low, 0.), high = std::min(high, static_cast<double>(grid.cols - 1));
  if (!(low <= high)) return;
  for (auto i = static_cast<Eigen::Index>(std::ceil(low)); static_cast<double>(i) <= high; ++i) {
    const double x = static_cast<double>(i) * grid.dx;
    row[border == Border::Open ? i : wrap(i, grid.cols)] -= scratch.depth *
                                                            bell(std::min(std::abs(u(x) / scratch.a), 1.)) *
                                                            bell(std::min(std::abs(v(x) / scratch.b), 1.));
  }
}

void check(const Brushing& b) {
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  if (!positive(b.length) || !positive(b.width) || !positive(b.coverage))
    throw InputError("scratches need a positive, finite length, width and coverage");
  if (!(b.rms >= 0) || !std::isfinite(b.rms))
    throw InputError("the rms height must be finite and not negative");
  if (!(b.spread >= 0 && b.spread <= std::numbers::pi / 2) || !std::isfinite(b.orientation))
    throw InputError("the spread must lie between 0 and 90 degrees, and the orientation be finite");
}

}  // namespace

double mean_depth(const Brushing& brushing) {
  // ⟨d²⟩ = 2 d̄², and ∬profile² = a b (256/315)² with independent a and b of means length/2 and width/2.
  const double area = brushing.length * brushing.width / 4 * kProfileSquared * kProfileSquared;
  return brushing.rms / std::sqrt(2 * density(brushing) * area);
}

HeightField brushed_surface(const SyntheticGrid& grid, const Brushing& brushing, std::uint64_t seed,
                            Border border) {
  check(grid);
  check(brushing);
  const std::vector<Scratch> scratches =
      draw_scratches(field_of_centres(grid, brushing, border), brushing, seed);
  Grid<double> z = Grid<double>::Zero(grid.rows, grid.cols);
  parallel_blocks(grid.rows, kRowsPerBlock, [&](Eigen::Index begin, Eigen::Index end) {
    for (const Scratch& scratch : scratches) {
      const double reach = std::abs(scratch.a * scratch.sin) + std::abs(scratch.b * scratch.cos);
      const auto first = static_cast<Eigen::Index>(std::ceil((scratch.y - reach) / grid.dy));
      const auto last = static_cast<Eigen::Index>(std::floor((scratch.y + reach) / grid.dy));
      if (border == Border::Open) {
        for (Eigen::Index j = std::max(first, begin); j <= std::min(last, end - 1); ++j)
          engrave_row(scratch, grid, border, j, &z(j, 0));
        continue;
      }
      for (Eigen::Index row = begin; row < end; ++row)
        for (Eigen::Index j = first + wrap(row - first, grid.rows); j <= last; j += grid.rows)
          engrave_row(scratch, grid, border, j, &z(row, 0));
    }
  });
  return make_height_field(z, grid.dx, grid.dy);
}

}  // namespace micro
