#include "texture/minify.h"

#include <algorithm>
#include <cmath>
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
LobePoints make_points(std::span<const Vec2> nodes, int angles) {
  LobePoints points;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const double u = nodes[k].x(), r = std::sqrt(u / (1 - u));
    for (int a = 0; a < angles; ++a) {
      // Rings are turned against each other.
      const double phi = 2 * std::numbers::pi * (a + 0.5 * static_cast<double>(k % 2)) / angles;
      points.v.emplace_back(r * std::cos(phi), r * std::sin(phi));
      points.weight.push_back(nodes[k].y() / angles);
    }
  }
  return points;
}

/// Three rings of six: what a step of minification takes.
const LobePoints& few_points() {
  static const LobePoints points = [] {
    const double a = std::sqrt(0.15);
    const std::array<Vec2, 3> nodes = {Vec2(0.5 - a, 5 / 18.), Vec2(0.5, 8 / 18.), Vec2(0.5 + a, 5 / 18.)};
    return make_points(nodes, 6);
  }();
  return points;
}

/// 24 rings of 32 by the midpoint rule: for misfits.
const LobePoints& many_points() {
  static const LobePoints points = [] {
    constexpr int kRings = 24;
    std::vector<Vec2> nodes;
    for (int k = 0; k < kRings; ++k)
      nodes.emplace_back((k + 0.5) / kRings, 1. / kRings);
    return make_points(nodes, 32);
  }();
  return points;
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
SlopeFrame start_of(std::span<const SlopeFrame> lobes) {
  Vec2 centre = {0, 0};
  double n = 0;
  for (const SlopeFrame& lobe : lobes) {
    if (!is_lobe(lobe)) continue;
    centre += lobe.centre;
    ++n;
  }
  if (n == 0) return no_lobe();
  centre /= n;
  Eigen::Matrix2d scale = Eigen::Matrix2d::Zero();
  for (const SlopeFrame& lobe : lobes) {
    if (!is_lobe(lobe)) continue;
    const Vec2 away = lobe.centre - centre;
    scale += (lobe.scale() + away * away.transpose()) / n;
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
SlopeFrame minified(std::span<const SlopeFrame> lobes, WeightedSlopes& slopes) {
  constexpr int kMost = 200;
  constexpr double kTolerance = 1e-4;
  SlopeFrame frame = start_of(lobes);
  if (!is_lobe(frame)) return frame;
  for (auto* values : {&slopes.x, &slopes.y, &slopes.weight})
    values->clear();
  const LobePoints& points = few_points();
  for (const SlopeFrame& lobe : lobes) {
    if (!is_lobe(lobe)) continue;
    for (std::size_t k = 0; k < points.v.size(); ++k) {
      const Vec2 slope = lobe.unwhiten(points.v[k]);
      slopes.x.push_back(slope.x());
      slopes.y.push_back(slope.y());
      slopes.weight.push_back(points.weight[k]);
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

}  // namespace

SlopeFrame minified(std::span<const SlopeFrame> lobes) {
  WeightedSlopes slopes;
  return minified(lobes, slopes);
}

Misfit misfit(std::span<const SlopeFrame> lobes, const SlopeFrame& lobe) {
  const LobePoints& points = many_points();
  double n = 0, divergence = 0, cross = 0, square = 0;
  for (const SlopeFrame& component : lobes)
    n += is_lobe(component) ? 1 : 0;
  if (n == 0) return {};
  for (const SlopeFrame& component : lobes) {
    if (!is_lobe(component)) continue;
    for (std::size_t k = 0; k < points.v.size(); ++k) {
      const Vec2 slope = component.unwhiten(points.v[k]);
      double mixture = 0;
      for (const SlopeFrame& other : lobes)
        if (is_lobe(other)) mixture += density(other, slope) / n;
      const double single = density(lobe, slope), weight = points.weight[k] / n;
      divergence += weight * std::log(mixture / single);
      square += weight * mixture;
      cross += weight * single;
    }
  }
  const double own = 1 / (3 * std::numbers::pi * lobe.l11 * lobe.l22);  // ∫ density²
  return {divergence, std::sqrt(std::max(0., (square - 2 * cross + own) / square))};
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

std::vector<SlopeFrame> covered(const TextureField& field, int levels, Eigen::Index row, Eigen::Index col) {
  const Eigen::Index side = Eigen::Index{1} << levels;
  std::vector<SlopeFrame> lobes;
  for (Eigen::Index j = row * side; j < std::min((row + 1) * side, field[0].rows()); ++j)
    for (Eigen::Index i = col * side; i < std::min((col + 1) * side, field[0].cols()); ++i)
      lobes.push_back(frame_at(field, j, i));
  return lobes;
}

TextureField minified(const TextureField& field, int levels) {
  const Eigen::Index rows = level_size(field[0].rows(), levels), cols = level_size(field[0].cols(), levels);
  TextureField coarse;
  for (auto& channel : coarse)
    channel.resize(rows, cols);
  parallel_for(rows, [&](std::int64_t j) {
    WeightedSlopes slopes;
    for (Eigen::Index i = 0; i < cols; ++i) {
      const SlopeFrame frame = minified(covered(field, levels, j, i), slopes);
      const SlopeCoordinates p = slope_coordinates(frame);
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
