#include "texture/minify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "core/parallel.h"
#include "distribution/scatter.h"

namespace micro {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kLeastWidth = 1e-12;

/// Points v of a round lobe and their weights. |v|² = u/(1 − u) with u uniform in (0, 1): Gauss–Legendre in u
/// by equal angles; any rule that is exact for u and has three angles or more leaves a lone lobe as it is.
struct LobePoints {
  std::vector<Vec2> v;
  std::vector<double> weight;
};

/// `turn` is in steps of the angle.
LobePoints make_points(std::span<const Vec2> nodes, int angles, double turn) {
  LobePoints points;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const double u = nodes[k].x(), r = std::sqrt(u / (1 - u));
    for (int a = 0; a < angles; ++a) {
      // Rings are turned against each other.
      const double phi = 2 * std::numbers::pi * (a + 0.5 * static_cast<double>(k % 2) + turn) / angles;
      points.v.emplace_back(r * std::cos(phi), r * std::sin(phi));
      points.weight.push_back(nodes[k].y() / angles);
    }
  }
  return points;
}

/// Three rings of six for the k-th of several lobes. Each lobe's are turned against its neighbours', by
/// sixteenths of a step in bit-reversed order: what six angles miss then averages out (widths to 1e-3,
/// where the same points for every lobe miss them by 1e-2).
const LobePoints& few_points(std::size_t k) {
  static constexpr std::array kTurns = {0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15};
  static const auto turned = [] {
    const double a = std::sqrt(0.15);
    const std::array<Vec2, 3> nodes = {Vec2(0.5 - a, 5 / 18.), Vec2(0.5, 8 / 18.), Vec2(0.5 + a, 5 / 18.)};
    std::array<LobePoints, kTurns.size()> sets;
    for (std::size_t t = 0; t < kTurns.size(); ++t)
      sets[t] = make_points(nodes, 6, kTurns[t] / 16.);
    return sets;
  }();
  return turned[k % turned.size()];
}

/// Rings by angles with the midpoint rule: for misfits.
LobePoints midpoints(int rings, int angles) {
  std::vector<Vec2> nodes;
  for (int k = 0; k < rings; ++k)
    nodes.emplace_back((k + 0.5) / rings, 1. / rings);
  return make_points(nodes, angles, 0);
}

bool is_lobe(const SlopeFrame& frame) {
  return !std::isnan(frame.l11);
}

/// Density of slopes.
double density(const SlopeFrame& frame, const Vec2& slope) {
  const double q = 1 + frame.whiten(slope).squaredNorm();
  return std::numbers::inv_pi / (frame.l11 * frame.l22 * q * q);
}

SlopeFrame no_lobe() {
  return {{kNaN, kNaN}, kNaN, kNaN, kNaN};
}

/// A frame between the lobes to start from: the mean of centres, and of scales plus the centres' spread.
SlopeFrame start_of(std::span<const SlopeFrame> lobes, std::span<const double> weights) {
  Vec2 centre = {0, 0};
  double n = 0;
  for (std::size_t k = 0; k < lobes.size(); ++k) {
    if (!is_lobe(lobes[k])) continue;
    centre += weights[k] * lobes[k].centre;
    n += weights[k];
  }
  if (n == 0) return no_lobe();
  centre /= n;
  Eigen::Matrix2d scale = Eigen::Matrix2d::Zero();
  for (std::size_t k = 0; k < lobes.size(); ++k) {
    if (!is_lobe(lobes[k])) continue;
    const Vec2 away = lobes[k].centre - centre;
    scale += weights[k] / n * (lobes[k].scale() + away * away.transpose());
  }
  SlopeFrame frame;
  frame.centre = centre;
  frame.l11 = std::sqrt(scale(0, 0));
  frame.l21 = scale(0, 1) / frame.l11;
  frame.l22 = std::sqrt(std::max(scale(1, 1) - frame.l21 * frame.l21, 1e-12 * scale(1, 1)));
  return frame;
}

double longest_step(const SlopeFrame& from, const SlopeFrame& to) {
  const Vec2 t = from.whiten(to.centre);
  return std::max({std::abs(t.x()), std::abs(t.y()), std::abs(to.l11 / from.l11 - 1),
                   std::abs(to.l22 / from.l22 - 1), std::abs(to.l21 - from.l21) / from.l22});
}

SlopeFrame frame_at(const TextureField& field, Eigen::Index j, Eigen::Index i) {
  if (std::isnan(field[0](j, i))) return no_lobe();
  SlopeCoordinates p;
  for (std::size_t c = 0; c < kChannels; ++c)
    p[c] = field[c](j, i);
  return frame_of(p);
}

/// minified() with memory of its caller's.
SlopeFrame minified(std::span<const SlopeFrame> lobes, std::span<const double> weights,
                    WeightedSlopes& slopes) {
  constexpr int kMost = 200;
  constexpr double kTolerance = 1e-4;
  SlopeFrame frame = start_of(lobes, weights);
  if (!is_lobe(frame)) return frame;
  for (auto* values : {&slopes.x, &slopes.y, &slopes.weight})
    values->clear();
  for (std::size_t n = 0; n < lobes.size(); ++n) {
    if (!is_lobe(lobes[n])) continue;
    const LobePoints& points = few_points(n);
    for (std::size_t k = 0; k < points.v.size(); ++k) {
      const Vec2 slope = lobes[n].unwhiten(points.v[k]);
      slopes.x.push_back(slope.x());
      slopes.y.push_back(slope.y());
      slopes.weight.push_back(weights[n] * points.weight[k]);
    }
  }
  for (int step = 0; step < kMost; ++step) {
    const SlopeFrame next = scatter_step(frame, slopes, kLeastWidth);
    const bool settled = longest_step(frame, next) < kTolerance;
    frame = next;
    if (settled) break;
  }
  return frame;
}

/// Slopes that are distributed as several lobes in equal parts are, each counting the same in all.
struct Draws {
  std::vector<Vec2> slopes;
  std::vector<double> weight;
};

void add_draws(Draws& draws, const SlopeFrame& lobe, const LobePoints& points, double share) {
  for (std::size_t k = 0; k < points.v.size(); ++k) {
    draws.slopes.push_back(lobe.unwhiten(points.v[k]));
    draws.weight.push_back(share * points.weight[k]);
  }
}

/// Of many lobes some 128 are drawn from; `lobes` holds no gaps.
Draws draws_of(std::span<const SlopeFrame> lobes) {
  constexpr std::size_t kFew = 16, kDrawn = 128;
  static const LobePoints kDense = midpoints(6, 16);
  const std::size_t stride = (lobes.size() + kDrawn - 1) / kDrawn, count = (lobes.size() - 1) / stride + 1;
  Draws draws;
  for (std::size_t k = 0; k < count; ++k)
    add_draws(draws, lobes[k * stride], lobes.size() <= kFew ? kDense : few_points(k),
              1 / static_cast<double>(count));
  return draws;
}

}  // namespace

SlopeFrame minified(std::span<const SlopeFrame> lobes) {
  WeightedSlopes slopes;
  return minified(lobes, std::vector<double>(lobes.size(), 1), slopes);
}

Misfit misfit(std::span<const SlopeFrame> lobes, const SlopeFrame& lobe) {
  static const LobePoints kOwn = midpoints(24, 32);
  std::vector<SlopeFrame> present;
  std::copy_if(lobes.begin(), lobes.end(), std::back_inserter(present), is_lobe);
  if (present.empty()) return {};
  Draws draws = draws_of(present);
  add_draws(draws, lobe, kOwn, 1);
  double divergence = 0, difference = 0, square = 0;
  for (std::size_t k = 0; k < draws.slopes.size(); ++k) {
    const Vec2& slope = draws.slopes[k];
    double mixture = 0;
    for (const SlopeFrame& other : present)
      mixture += density(other, slope);
    mixture /= static_cast<double>(present.size());
    const double single = density(lobe, slope);
    // Draws of both together lie as mixture + lobe do [Veach95, balance heuristic].
    const double weight = draws.weight[k] / (mixture + single);
    divergence += weight * (mixture * std::log(mixture / single) - mixture + single);
    difference += weight * (mixture - single) * (mixture - single);
    square += weight * mixture * mixture;
  }
  return {std::max(0., divergence), std::sqrt(difference / square)};
}

SlopeFrame naive_average(std::span<const SlopeFrame> lobes) {
  EllipsoidParameters mean = {0, 0, 0, 0, 0};
  double n = 0;
  for (const SlopeFrame& lobe : lobes) {
    if (!is_lobe(lobe)) continue;
    const EllipsoidParameters p = canonical_parameters(lobe);
    mean.alpha_x += p.alpha_x;
    mean.alpha_y += p.alpha_y;
    mean.theta_x += p.theta_x;
    mean.theta_y += p.theta_y;
    mean.theta_z += p.theta_z;
    ++n;
  }
  if (n == 0) return no_lobe();
  return slope_frame(
      {mean.alpha_x / n, mean.alpha_y / n, mean.theta_x / n, mean.theta_y / n, mean.theta_z / n});
}

std::vector<SlopeFrame> covered(const TextureField& field, int levels, Eigen::Index row, Eigen::Index col,
                                Eigen::Index most) {
  const Eigen::Index side = Eigen::Index{1} << levels, top = row * side, left = col * side;
  const Eigen::Index rows = std::min(side, field[0].rows() - top),
                     cols = std::min(side, field[0].cols() - left);
  int coarser = 0;
  while (level_size(rows, coarser) * level_size(cols, coarser) > most)
    ++coarser;
  std::vector<SlopeFrame> lobes;
  for (Eigen::Index j = 0; j < rows; j += Eigen::Index{1} << coarser)
    for (Eigen::Index i = 0; i < cols; i += Eigen::Index{1} << coarser)
      lobes.push_back(frame_at(field, top + j, left + i));
  return lobes;
}

TextureField minified(const TextureField& field, int levels) {
  return minified(field, levels, {field[0].rows(), field[0].cols()}, 0);
}

TextureField minified(const TextureField& field, int levels, const TextureSize& finest, int level) {
  const Eigen::Index rows = level_size(field[0].rows(), levels), cols = level_size(field[0].cols(), levels);
  const Eigen::Index side = Eigen::Index{1} << levels, span = Eigen::Index{1} << level;
  TextureField coarse;
  for (auto& channel : coarse)
    channel.resize(rows, cols);
  parallel_for(rows, [&](std::int64_t j) {
    WeightedSlopes slopes;
    std::vector<SlopeFrame> lobes;
    std::vector<double> weights;
    for (Eigen::Index i = 0; i < cols; ++i) {
      lobes.clear();
      weights.clear();
      for (Eigen::Index b = j * side; b < std::min((j + 1) * side, field[0].rows()); ++b)
        for (Eigen::Index a = i * side; a < std::min((i + 1) * side, field[0].cols()); ++a) {
          lobes.push_back(frame_at(field, b, a));
          weights.push_back(static_cast<double>(std::min(span, finest.rows - b * span) *
                                                std::min(span, finest.cols - a * span)));
        }
      const SlopeCoordinates p = slope_coordinates(minified(lobes, weights, slopes));
      for (std::size_t c = 0; c < kChannels; ++c)
        coarse[c](j, i) = static_cast<float>(p[c]);
    }
  });
  return coarse;
}

int level_count(const TextureSize& size) {
  int levels = 1;
  while (level_size(std::max(size.rows, size.cols), levels - 1) > 1)
    ++levels;
  return levels;
}

}  // namespace micro
