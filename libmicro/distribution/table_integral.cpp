#include "distribution/table_integral.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <queue>
#include <utility>
#include <vector>

namespace micro {
namespace {

/// Mass ∫ D dm_x dm_y and first moments.
struct Moments {
  double mass = 0, x = 0, y = 0;

  Moments& operator+=(const Moments& other) {
    mass += other.mass;
    x += other.x;
    y += other.y;
    return *this;
  }
};

/// A square of 2^level cells a side, or of a part of a cell where level < 0.
struct Square {
  int level;
  Eigen::Index row, col;

  std::array<Square, 4> quarters() const {
    return {{{level - 1, 2 * row, 2 * col},
             {level - 1, 2 * row, 2 * col + 1},
             {level - 1, 2 * row + 1, 2 * col},
             {level - 1, 2 * row + 1, 2 * col + 1}}};
  }
};

/// Of a bilinear function on the square of side w whose first corner is (x, y).
Moments bilinear_moments(const std::array<double, 4>& d, double x, double y, double w) {
  const double sum = d[0] + d[1] + d[2] + d[3], mass = sum * w * w / 4, third = w * w * w / 12;
  return {mass, x * mass + third * (sum + d[1] + d[3]), y * mass + third * (sum + d[2] + d[3])};
}

constexpr int kFirstKept = 3;  // squares of 8 × 8 cells and more are kept, the others summed when needed
constexpr int kMostHalvings = 20;

}  // namespace

struct TableIntegral::State {
  explicit State(Tabulated source) : table(std::move(source)) {}

  Tabulated table;

  Eigen::Index cells() const { return table.table().grid.size - 1; }
  Eigen::Index squares(int level) const { return (cells() + (Eigen::Index{1} << level) - 1) >> level; }

  void keep_large_squares() {
    std::call_once(once_, [&] {
      for (int level = kFirstKept; level == kFirstKept || squares(level - 1) > 1; ++level) {
        Grid<Moments> sums(squares(level), squares(level));
        for (Eigen::Index j = 0; j < sums.rows(); ++j)
          for (Eigen::Index i = 0; i < sums.cols(); ++i)
            sums(j, i) = sum_of_quarters({level, j, i});
        kept_.push_back(std::move(sums));
      }
    });
  }

  /// In m_xy.
  std::array<Vec2, 4> corners(const Square& square) const {
    const DiskGrid& grid = table.table().grid;
    const double w = std::ldexp(grid.spacing(), square.level);
    const double x = static_cast<double>(square.col) * w - grid.extent,
                 y = static_cast<double>(square.row) * w - grid.extent;
    return {Vec2(x, y), Vec2(x + w, y), Vec2(x, y + w), Vec2(x + w, y + w)};
  }

  Moments moments(const Square& square) const {
    if (square.level < 0) return part_of_cell(square);
    const Eigen::Index n = squares(square.level);
    if (square.row >= n || square.col >= n) return {};
    if (square.level == 0) return part_of_cell(square);
    const auto place = static_cast<std::size_t>(square.level - kFirstKept);
    return square.level >= kFirstKept && place < kept_.size() ? kept_[place](square.row, square.col)
                                                              : sum_of_quarters(square);
  }

 private:
  Moments sum_of_quarters(const Square& square) const {
    Moments sum;
    for (const Square& quarter : square.quarters())
      sum += moments(quarter);
    return sum;
  }

  /// Of a cell or less. D is zero in the middle of a cell where it is zero in all of it.
  Moments part_of_cell(const Square& square) const {
    const DiskTable& disk = table.table();
    const double h = disk.grid.spacing(), w = std::ldexp(1., square.level);
    const auto place = [&](Eigen::Index k) { return static_cast<double>(k) * w; };
    const auto j = static_cast<Eigen::Index>(place(square.row)),
               i = static_cast<Eigen::Index>(place(square.col));
    const double middle_x = disk.grid.coordinate(i) + h / 2, middle_y = disk.grid.coordinate(j) + h / 2;
    const double z2 = 1 - middle_x * middle_x - middle_y * middle_y;
    if (!(z2 > 0 && table.D({middle_x, middle_y, std::sqrt(z2)}) > 0)) return {};
    const double s = place(square.row) - static_cast<double>(j),
                 t = place(square.col) - static_cast<double>(i);
    const Grid<double>& d = disk.density;
    const auto at = [&](double down, double along) {
      return std::lerp(std::lerp(d(j, i), d(j, i + 1), along), std::lerp(d(j + 1, i), d(j + 1, i + 1), along),
                       down);
    };
    return bilinear_moments({at(s, t), at(s, t + w), at(s + w, t), at(s + w, t + w)},
                            disk.grid.coordinate(i) + t * h, disk.grid.coordinate(j) + s * h, w * h);
  }

  std::once_flag once_;
  std::vector<Grid<Moments>> kept_;
};

TableIntegral::TableIntegral(Tabulated table) : state_(std::make_shared<State>(std::move(table))) {}

/// One square's part of an integral: by one point in each of its quarters.
struct Part {
  double error, value;
  Square square;
  bool operator<(const Part& other) const { return error < other.error; }
};

/// Integrates g by one point, and counts how often g is asked.
class OnePointRule {
 public:
  OnePointRule(const std::function<double(const Vec3&)>& g, const TableIntegral::State& state)
      : g_(g), state_(state) {}

  std::int64_t evaluations() const { return evaluations_; }

  Part part(const Square& square) {
    const Moments whole = state_.moments(square);
    if (!(whole.mass > 0)) return {0, 0, square};
    Range range;
    double quarters = 0;
    for (const Square& quarter : square.quarters())
      quarters += at_centre(state_.moments(quarter), range);
    const double difference = std::abs(quarters - at_centre(whole, range));
    for (const Vec2& corner : state_.corners(square))
      if (corner.squaredNorm() < 1)
        at(corner, range);
      else
        range.least = 0;
    const bool ends_within = range.least == 0 && range.most > 0;
    return {ends_within ? std::max(difference, whole.mass * range.most) : difference, quarters, square};
  }

 private:
  /// Of |g| where it was asked.
  struct Range {
    double least = INFINITY, most = 0;
  };

  double at(const Vec2& m, Range& range) {
    ++evaluations_;
    const double value = g_({m.x(), m.y(), std::sqrt(std::max(0., 1 - m.squaredNorm()))});
    range.least = std::min(range.least, std::abs(value));
    range.most = std::max(range.most, std::abs(value));
    return value;
  }
  double at_centre(const Moments& moments, Range& range) {
    const double mass = moments.mass;
    return mass > 0 ? mass * at({moments.x / mass, moments.y / mass}, range) : 0;
  }

  const std::function<double(const Vec3&)>& g_;
  const TableIntegral::State& state_;
  std::int64_t evaluations_ = 0;
};

Estimate<double> TableIntegral::operator()(const std::function<double(const Vec3& m)>& g,
                                           double tolerance) const {
  constexpr Eigen::Index kFewest = 32;  // squares a side to begin with
  constexpr std::int64_t kMost = 4'000'000;
  const Stopwatch watch;
  state_->keep_large_squares();
  OnePointRule rule(g, *state_);
  int level = 0;
  while (state_->squares(level) > kFewest)
    ++level;
  const int finest = level - kMostHalvings;
  std::priority_queue<Part> parts;
  double value = 0, error = 0;
  const auto add = [&](const Part& part) {
    value += part.value;
    error += part.error;
    parts.push(part);
  };
  for (Eigen::Index j = 0; j < state_->squares(level); ++j)
    for (Eigen::Index i = 0; i < state_->squares(level); ++i)
      add(rule.part({level, j, i}));
  while (error > tolerance && rule.evaluations() < kMost && parts.top().square.level > finest) {
    const Part worst = parts.top();
    parts.pop();
    value -= worst.value;
    error -= worst.error;
    for (const Square& quarter : worst.square.quarters())
      add(rule.part(quarter));
  }
  return {value, std::abs(error), {watch.seconds(), rule.evaluations()}};
}

}  // namespace micro
