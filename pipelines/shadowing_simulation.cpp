#include "pipelines/shadowing_simulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/parallel.h"
#include "height/gaussian_surface.h"

namespace micro {
namespace {

/// A ray has left the surface when it has risen this far, in σ_h: profiles reach ±5 at most.
constexpr double kRise = 10;
/// Facets of smaller slopes are level, σ_h/τ.
constexpr double kLevel = 0.1;

/// Rays that start somewhere and those of them that escape.
struct Count {
  double rays = 0, escaped = 0;
  void add(bool escapes) {
    rays += 1;
    escaped += escapes ? 1 : 0;
  }
};

/// Σ escaped/Σ rays over independent profiles, with the standard error of this ratio.
class Ratio {
 public:
  void add(const Count& count) {
    ++profiles_;
    rays_ += count.rays;
    escaped_ += count.escaped;
    rays2_ += count.rays * count.rays;
    escaped2_ += count.escaped * count.escaped;
    product_ += count.rays * count.escaped;
  }
  Estimate<double> estimate() const {
    const double r = escaped_ / rays_, n = profiles_;
    const double square = escaped2_ - 2 * r * product_ + r * r * rays2_;
    return {r, std::sqrt(std::max(0., square) * n / (n - 1)) / rays_, {0, static_cast<std::int64_t>(rays_)}};
  }

 private:
  double profiles_ = 0, rays_ = 0, escaped_ = 0, rays2_ = 0, escaped2_ = 0, product_ = 0;
};

/// What is counted of all rays and of those from facing facets.
template <typename T>
struct Parts {
  T all, facing;
};
EscapingPart estimate(const Parts<Ratio>& parts) {
  return {parts.all.estimate(), parts.facing.estimate()};
}
void add(Parts<Ratio>& sum, const Parts<Count>& count) {
  sum.all.add(count.all);
  sum.facing.add(count.facing);
}
void add(Parts<Count>& sum, bool facing, bool escapes) {
  sum.all.add(escapes);
  if (facing) sum.facing.add(escapes);
}

template <typename T>
struct Tally {
  std::array<Parts<T>, HeightBins::kCount> heights{};
  Parts<T> anywhere, both;
  T level{}, crossings{};
};

using Profile = std::vector<double>;

/// u_k = h_k − k·rise, and the largest of u_k, u_{k+1} ….
struct RaisedProfile {
  Profile u, ahead;
  RaisedProfile(const Profile& h, double rise) : u(h.size()), ahead(h.size()) {
    double largest = -std::numeric_limits<double>::infinity();
    for (std::size_t k = h.size(); k-- > 0;) {
      u[k] = h[k] - static_cast<double>(k) * rise;
      largest = std::max(largest, u[k]);
      ahead[k] = largest;
    }
  }
  bool faces(std::size_t k) const { return u[k] >= u[k + 1]; }
  bool escapes(std::size_t k) const { return u[k] >= ahead[k + 1]; }
};

/// Rays from all points of [first, last) to both sides; `mirrored` is the profile read from its other end.
Tally<Count> tally(const Profile& h, const Profile& mirrored, double rise, std::size_t first,
                   std::size_t last, double level_step) {
  Tally<Count> counts;
  const RaisedProfile right(h, rise), left(mirrored, rise);
  const std::size_t n = h.size();
  for (std::size_t k = first; k < last; ++k) {
    const std::size_t m = n - 1 - k;
    const bool faces_right = right.faces(k), faces_left = left.faces(m);
    const bool to_right = right.escapes(k), to_left = left.escapes(m);
    add(counts.anywhere, faces_right, to_right);
    add(counts.anywhere, faces_left, to_left);
    add(counts.both, faces_right && faces_left, to_right && to_left);
    if (std::abs(h[k + 1] - h[k]) < level_step) counts.level.add(to_right && to_left);
    const long bin = std::lrint(h[k] / HeightBins::kWidth) + HeightBins::kMean;
    if (bin >= 0 && bin < HeightBins::kCount) {
      Parts<Count>& here = counts.heights[static_cast<std::size_t>(bin)];
      add(here, faces_right, to_right);
      add(here, faces_left, to_left);
    }
    if ((h[k] < 0) != (h[k + 1] < 0)) {
      const double part = h[k] / (h[k] - h[k + 1]), x = static_cast<double>(k) + part;
      counts.crossings.add(-rise * x >= right.ahead[k + 1]);
      counts.crossings.add(-rise * (static_cast<double>(n - 1) - x) >= left.ahead[m]);
    }
  }
  return counts;
}

void add(Tally<Ratio>& sum, const Tally<Count>& count) {
  for (std::size_t bin = 0; bin < sum.heights.size(); ++bin)
    add(sum.heights[bin], count.heights[bin]);
  add(sum.anywhere, count.anywhere);
  add(sum.both, count.both);
  sum.level.add(count.level);
  sum.crossings.add(count.crossings);
}

ShadowingRow row_of(double nu, const Tally<Ratio>& sum) {
  ShadowingRow row;
  row.nu = nu;
  for (const Parts<Ratio>& parts : sum.heights)
    row.from_height.push_back(estimate(parts));
  row.from_crossings = sum.crossings.estimate();
  row.from_anywhere = estimate(sum.anywhere);
  row.both_ways = estimate(sum.both);
  row.level_both_ways = sum.level.estimate();
  row.rays = row.from_anywhere.all.cost.evaluations;
  return row;
}

}  // namespace

std::vector<double> gaussian_profile(std::int64_t points, int points_per_tau, std::uint64_t seed) {
  const HeightField surface =
      gaussian_surface({1, points, 1. / points_per_tau, 1. / points_per_tau}, {1, 1, 1, 0}, seed);
  std::vector<double> heights(static_cast<std::size_t>(points));
  for (std::size_t k = 0; k < heights.size(); ++k)
    heights[k] = static_cast<double>(surface.z(0, static_cast<Eigen::Index>(k))) + surface.mean;
  return heights;
}

std::vector<char> escapes_to_the_right(const std::vector<double>& profile, double rise) {
  std::vector<char> escapes(profile.size(), 1);
  const RaisedProfile raised(profile, rise);
  for (std::size_t k = 0; k + 1 < profile.size(); ++k)
    escapes[k] = raised.escapes(k) ? 1 : 0;
  return escapes;
}

std::vector<ShadowingRow> simulate_shadowing(const ShadowingRequest& request) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const double nu : request.nu) {
    if (!(nu > 0)) throw InputError("rays at or below the horizon never leave a surface");
    lowest = std::min(lowest, nu);
  }
  if (request.profiles < 2) throw InputError("error bars take at least two profiles");
  const double per_tau = request.points_per_tau;
  const auto margin = static_cast<std::size_t>(std::ceil(kRise / lowest * per_tau)) + 1;
  const auto starts =
      static_cast<std::size_t>(request.length) * static_cast<std::size_t>(request.points_per_tau);
  std::vector<Tally<Ratio>> sums(request.nu.size());
  parallel_in_order(
      request.profiles,
      [&](std::int64_t i) {
        const Profile h =
            gaussian_profile(static_cast<std::int64_t>(starts + 2 * margin), request.points_per_tau,
                             request.seed + static_cast<std::uint64_t>(i));
        const Profile mirrored(h.rbegin(), h.rend());
        std::vector<Tally<Count>> counts;
        for (const double nu : request.nu)
          counts.push_back(tally(h, mirrored, nu / per_tau, margin, margin + starts, kLevel / per_tau));
        return counts;
      },
      [&](std::int64_t, const std::vector<Tally<Count>>& counts) {
        for (std::size_t k = 0; k < sums.size(); ++k)
          add(sums[k], counts[k]);
      });
  std::vector<ShadowingRow> rows;
  for (std::size_t k = 0; k < sums.size(); ++k)
    rows.push_back(row_of(request.nu[k], sums[k]));
  return rows;
}

}  // namespace micro
