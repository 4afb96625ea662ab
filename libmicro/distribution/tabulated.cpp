#include "distribution/tabulated.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <mutex>
#include <optional>

#include "core/error.h"
#include "core/random.h"
#include "distribution/cell_sampling.h"
#include "distribution/masking_table.h"
#include "distribution/scatter.h"

namespace micro {
namespace {

constexpr std::size_t kScatterNodes = 8192;

/// Is every node of the cell (j, i)…(j+1, i+1) on the disk, and half a spacing above its rim? (All that are
/// on the disk are, at extent 1.)
bool is_whole(const DiskGrid& grid, Eigen::Index j, Eigen::Index i) {
  const auto far = [&](Eigen::Index k) {
    return 2 * k + 1 >= grid.size ? k + 1 : k;  // the node farther from the axis
  };
  return grid.mz2(far(j), far(i)) > grid.spacing() * grid.spacing() / 4;
}

/// The cells that hold mass: rows first_row…, columns first_col….
struct CellBox {
  Eigen::Index row = 0, col = 0;
  Grid<double> mass;  // ∫ D dm_x dm_y of each cell
};

CellBox cells_with_mass(const DiskTable& table) {
  const DiskGrid& grid = table.grid;
  const Eigen::Index n = grid.size - 1;
  const Grid<double>& d = table.density;
  Grid<double> mass = Grid<double>::Zero(n, n);
  Eigen::Index top = n, bottom = -1, left = n, right = -1;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i) {
      const double sum = d(j, i) + d(j, i + 1) + d(j + 1, i) + d(j + 1, i + 1);
      if (!(sum > 0) || !is_whole(grid, j, i)) continue;
      mass(j, i) = sum / 4 * grid.spacing() * grid.spacing();
      top = std::min(top, j);
      bottom = std::max(bottom, j);
      left = std::min(left, i);
      right = std::max(right, i);
    }
  if (bottom < 0) throw InputError("the table holds no mass that could be sampled");
  return {top, left, mass.block(top, left, bottom - top + 1, right - left + 1)};
}

/// t in [0, 1] with density ∝ a(1 − t) + b·t.
double sample_linear(double a, double b, double xi) {
  const double root = std::sqrt(a * a * (1 - xi) + b * b * xi);
  return a + root > 0 ? std::min(1., xi * (a + b) / (a + root)) : xi;
}

/// The largest |e·slope − offset| in a cell. The gradient of e·slope on the disk vanishes nowhere, so the
/// extremes stand in a corner, or on a side: on x = const where (1 − x²)·e_y + x·y·e_x = 0.
double largest(const DiskGrid& grid, Eigen::Index j, Eigen::Index i, const Vec2& e, double offset) {
  const std::array x = {grid.coordinate(i), grid.coordinate(i + 1)},
                   y = {grid.coordinate(j), grid.coordinate(j + 1)};
  double most = 0;
  const auto visit = [&](double mx, double my) {
    const double value = -(e.x() * mx + e.y() * my) / std::sqrt(1 - mx * mx - my * my);
    most = std::max(most, std::abs(value - offset));
  };
  for (const double mx : x) {
    const double my = -(1 - mx * mx) * e.y() / (mx * e.x());
    for (const double end : y)
      visit(mx, end);
    if (my > y[0] && my < y[1]) visit(mx, my);
  }
  for (const double my : y) {
    const double mx = -(1 - my * my) * e.x() / (my * e.y());
    if (mx > x[0] && mx < x[1]) visit(mx, my);
  }
  return most;
}

}  // namespace

/// The weight of a visible normal, (u'_z − v·u'_xy)₊ in whitened slopes, is at most max(u'_z, 0) +
/// |u'_1||v_1| + |u'_2||v_2|: three distributions of cells that don't depend on u bound it closely for lobes
/// of any shape.
struct VisibleSampling {
  Grid<double> bound1, bound2;  // largest |v_1| and |v_2| in a cell
  CellSampling along1, along2;
};

struct Tabulated::State {
  DiskTable table;
  SlopeFrame frame;
  CellBox cells;
  double mass;

  explicit State(const DiskTable& source)
      : table(source),
        frame(slope_scatter(core_nodes(source, kScatterNodes), source.grid)),
        cells(cells_with_mass(source)),
        mass(cells.mass.sum()) {}

  const MaskingTable& masking() {
    std::call_once(masking_once_, [&] { masking_.emplace(frame, slope_points()); });
    return *masking_;
  }
  const CellSampling& plain() {
    std::call_once(plain_once_, [&] { plain_.emplace(cells.mass); });
    return *plain_;
  }
  const VisibleSampling& visible() {
    std::call_once(visible_once_, [&] { visible_.emplace(visible_sampling()); });
    return *visible_;
  }

  /// u' in the lobe's own frame: slopes v weigh (up − v·across)₊.
  struct Seen {
    Vec2 across;
    double up;
  };
  Seen seen_from(const Vec3& u) const {
    return {{frame.l11 * u.x() + frame.l21 * u.y(), frame.l22 * u.y()},
            u.z() - frame.centre.dot(u.head<2>())};
  }
  bool hardly_visible(const Vec3& u) {
    constexpr double kHardly = 1e-4;
    const auto [across, up] = seen_from(u);
    return !(masking().visible_area(u) > kHardly * mass * std::hypot(across.x(), across.y(), up));
  }

  /// D and its derivatives by m_x and m_y times the spacing, at (t, s) of a cell.
  struct Bilinear {
    double value, dx, dy;
  };
  Bilinear bilinear(Eigen::Index j, Eigen::Index i, double t, double s) const {
    const double* corner = &table.density(j, i);
    const double* below = corner + table.grid.size;
    const double up = (1 - t) * corner[0] + t * corner[1], down = (1 - t) * below[0] + t * below[1];
    return {(1 - s) * up + s * down, (1 - s) * (corner[1] - corner[0]) + s * (below[1] - below[0]),
            down - up};
  }

  double D(const Vec3& m) const {
    const DiskGrid& grid = table.grid;
    const double x = (m.x() + grid.extent) / grid.spacing(), y = (m.y() + grid.extent) / grid.spacing();
    const auto last = static_cast<double>(grid.size - 1);
    if (!(m.z() >= 0 && x >= 0 && y >= 0 && x <= last && y <= last)) return 0;
    const auto i = std::min(static_cast<Eigen::Index>(x), static_cast<Eigen::Index>(grid.size) - 2),
               j = std::min(static_cast<Eigen::Index>(y), static_cast<Eigen::Index>(grid.size) - 2);
    if (!is_whole(grid, j, i)) return 0;
    return bilinear(j, i, x - static_cast<double>(i), y - static_cast<double>(j)).value;
  }

  /// A point of the cell (row, col of the box) with density ∝ D.
  Vec3 in_cell(const CellSampling::Cell& cell) const {
    const Eigen::Index j = cells.row + cell.row, i = cells.col + cell.col;
    const Grid<double>& d = table.density;
    const double s = sample_linear(d(j, i) + d(j, i + 1), d(j + 1, i) + d(j + 1, i + 1), cell.xi.y());
    const double t = sample_linear((1 - s) * d(j, i) + s * d(j + 1, i),
                                   (1 - s) * d(j, i + 1) + s * d(j + 1, i + 1), cell.xi.x());
    const double h = table.grid.spacing(), x = table.grid.coordinate(i) + t * h,
                 y = table.grid.coordinate(j) + s * h;
    return {x, y, std::sqrt(std::max(0., 1 - x * x - y * y))};
  }

  double bound1(Eigen::Index row, Eigen::Index col) const {
    return largest(table.grid, cells.row + row, cells.col + col, {1 / frame.l11, 0},
                   frame.centre.x() / frame.l11);
  }
  double bound2(Eigen::Index row, Eigen::Index col) const {
    const Vec2 e(-frame.l21 / frame.l11 / frame.l22, 1 / frame.l22);
    return largest(table.grid, cells.row + row, cells.col + col, e, e.dot(frame.centre));
  }

 private:
  VisibleSampling visible_sampling() const {
    Grid<double> b1 = Grid<double>::Zero(cells.mass.rows(), cells.mass.cols()), b2 = b1;
    for (Eigen::Index j = 0; j < b1.rows(); ++j)
      for (Eigen::Index i = 0; i < b1.cols(); ++i)
        if (cells.mass(j, i) > 0) {
          b1(j, i) = bound1(j, i);
          b2(j, i) = bound2(j, i);
        }
    CellSampling along1(cells.mass * b1), along2(cells.mass * b2);
    return {std::move(b1), std::move(b2), std::move(along1), std::move(along2)};
  }

  /// The bilinear function as points: each cell in n × n parts, with the part's own mean and covariance. More
  /// parts where the table is small, and where slopes change fast within a cell: towards the horizon.
  SlopePoints slope_points() const {
    constexpr double kEnough = 65536, kMostParts = 12;
    const DiskGrid& grid = table.grid;
    const double h = grid.spacing(), cell_count = static_cast<double>((cells.mass > 0).count());
    const double parts = std::sqrt(kEnough / cell_count);
    SlopePoints points;
    for (Eigen::Index row = 0; row < cells.mass.rows(); ++row)
      for (Eigen::Index col = 0; col < cells.mass.cols(); ++col) {
        if (!(cells.mass(row, col) > 0)) continue;
        const Eigen::Index j = cells.row + row, i = cells.col + col;
        const double mz2 =
            std::min({grid.mz2(j, i), grid.mz2(j, i + 1), grid.mz2(j + 1, i), grid.mz2(j + 1, i + 1)});
        const double n = std::ceil(std::clamp(std::max(parts, 8 * h / mz2), 1., kMostParts));
        for (double s = 0.5 / n; s < 1; s += 1 / n)
          for (double t = 0.5 / n; t < 1; t += 1 / n)
            add_point(points, {grid.coordinate(i) + t * h, grid.coordinate(j) + s * h}, h / n,
                      bilinear(j, i, t, s));
      }
    return points;
  }

  /// Of a square of a bilinear density: the mean over it is that at its middle, the mean place is width²/12
  /// of the gradient of ln D away from there, the covariance what that leaves of width²/12.
  void add_point(SlopePoints& points, const Vec2& middle, double width, const Bilinear& density) const {
    const auto share = static_cast<float>(density.value * width * width);
    if (!(share > 0)) return;
    const double variance = width * width / 12;
    const Vec2 away = variance / (density.value * table.grid.spacing()) * Vec2(density.dx, density.dy);
    const double x = middle.x() + away.x(), y = middle.y() + away.y();
    const double z2 = 1 - x * x - y * y, z = std::sqrt(z2);
    const Vec2 v = frame.whiten({-x / z, -y / z});
    // ∂slope/∂m_xy = −(1 + m_xy·m_xyᵀ/m_z²)/m_z, then L⁻¹.
    const Vec2 sx = Vec2(1 + x * x / z2, x * y / z2) / z, sy = Vec2(x * y / z2, 1 + y * y / z2) / z;
    const Vec2 g1 = sx / frame.l11, g2 = (sy - frame.l21 * g1) / frame.l22;
    const double a1 = away.dot(g1), a2 = away.dot(g2);
    points.mass.push_back(share);
    points.v1.push_back(static_cast<float>(v.x()));
    points.v2.push_back(static_cast<float>(v.y()));
    points.spread11.push_back(static_cast<float>(variance * g1.squaredNorm() - a1 * a1));
    points.spread12.push_back(static_cast<float>(variance * g1.dot(g2) - a1 * a2));
    points.spread22.push_back(static_cast<float>(variance * g2.squaredNorm() - a2 * a2));
  }

  std::once_flag masking_once_, plain_once_, visible_once_;
  std::optional<MaskingTable> masking_;
  std::optional<CellSampling> plain_;
  std::optional<VisibleSampling> visible_;
};

Tabulated::Tabulated(const DiskTable& table) {
  if (!(table.density.minCoeff() >= 0 && table.density.maxCoeff() < INFINITY) || table.density.hasNaN())
    throw InputError("the table holds a density that is negative or not finite");
  state_ = std::make_shared<State>(table);
}

const DiskTable& Tabulated::table() const {
  return state_->table;
}
double Tabulated::mass() const {
  return state_->mass;
}
double Tabulated::D(const Vec3& m) const {
  return state_->D(m);
}
double Tabulated::visible_area(const Vec3& u) const {
  return state_->masking().visible_area(u);
}

double Tabulated::G1(const Vec3& u) const {
  if (!(u.z() > 0)) return 0;
  const double area = visible_area(u), mean_plane = state_->mass * u.z();
  return mean_plane < area ? mean_plane / area : 1;
}

Vec3 Tabulated::sample(const Vec2& xi) const {
  return state_->in_cell(state_->plain()(xi));
}
double Tabulated::pdf(const Vec3& m) const {
  return D(m) * std::max(0., m.z()) / state_->mass;
}

Vec3 Tabulated::sample_visible(const Vec3& u, const Vec2& xi) const {
  constexpr std::uint64_t kTries = 4'000'000;  // one in 1e5 is accepted at least
  if (state_->hardly_visible(u)) return sample(xi);
  const SlopeFrame& frame = state_->frame;
  const VisibleSampling& visible = state_->visible();
  const CellSampling& plain = state_->plain();
  const auto [across, up] = state_->seen_from(u);
  const double w0 = std::max(0., up), w1 = std::abs(across.x()), w2 = std::abs(across.y());
  const std::array weights = {w0 * plain.total(), w1 * visible.along1.total(), w2 * visible.along2.total()};
  const double whole = weights[0] + weights[1] + weights[2];
  const std::uint64_t seed = std::bit_cast<std::uint64_t>(xi.x());
  const auto stream = static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(xi.y()) >> 20);
  for (std::uint64_t k = 0; k < kTries; ++k) {
    const auto [r, accept] = random_uniform(seed, stream, 2 * k);
    const auto [a, b] = random_uniform(seed, stream, 2 * k + 1);
    const Vec2 numbers = k == 0 ? xi : Vec2(a, b);
    const double choice = r * whole;
    const CellSampling::Cell cell = choice < weights[0]                ? plain(numbers)
                                    : choice < weights[0] + weights[1] ? visible.along1(numbers)
                                                                       : visible.along2(numbers);
    const Vec3 m = state_->in_cell(cell);
    const double bound =
        w0 + w1 * visible.bound1(cell.row, cell.col) + w2 * visible.bound2(cell.row, cell.col);
    const double weight = up - frame.whiten(slope_of(m)).dot(across);
    if (accept * bound < weight) return m;
  }
  return sample(xi);
}

double Tabulated::pdf_visible(const Vec3& u, const Vec3& m) const {
  if (state_->hardly_visible(u)) return pdf(m);
  return D(m) * std::max(0., m.dot(u)) / visible_area(u);
}

}  // namespace micro
