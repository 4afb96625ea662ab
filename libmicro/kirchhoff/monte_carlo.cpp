#include "kirchhoff/monte_carlo.h"

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <string>

#include "core/error.h"
#include "core/parallel.h"
#include "height/triangles.h"
#include "kirchhoff/monte_carlo_kernel.h"

namespace micro {
namespace {

using Complex = std::complex<double>;
using detail::DrawSums;
using detail::PointsPerDraw;
using detail::Stratum;
using detail::TriangleTile;

/// Largest phase (rad) left to float arithmetic: half a unit in the last place is 2e-6 there, and errors of
/// different points are independent.
constexpr double kFloatPhase = 64;
/// Parts along each side of a window for the local mean of D.
constexpr Eigen::Index kParts = 4;
/// Directions handled together: enough to make drawing points cheap, few enough to bound the memory of the
/// sums (a surface of 4096 × 4096 points has 1024 runs of tiles: 30 MB).
constexpr std::size_t kDirectionBatch = 512;

PointsPerDraw points_per_draw(Draws draws) {
  return draws == Draws::Rotated ? PointsPerDraw::Three : PointsPerDraw::One;
}

/// The n² similar triangles of a triangle; streams of different n never meet: 0²+1²+…+(n−1)² come before.
std::vector<Stratum> strata(int n, std::uint64_t seed) {
  std::vector<Stratum> result;
  auto stream = static_cast<std::uint32_t>(static_cast<std::int64_t>(n - 1) * n * (2 * n - 1) / 6);
  for (int p = 0; p < n; ++p)
    for (int r = 0; p + r < n; ++r) {
      result.push_back({seed, stream++, static_cast<double>(p) / n, static_cast<double>(r) / n, 1.0 / n});
      if (p + r + 1 < n)  // upside down
        result.push_back(
            {seed, stream++, static_cast<double>(p + 1) / n, static_cast<double>(r + 1) / n, -1.0 / n});
    }
  return result;
}

/// Where a tile lies among the cells of a window.
struct TilePlace {
  Eigen::Index row, col, rows, cols;  ///< cells
  std::int64_t number;
  Eigen::Index part;  ///< of the kParts² parts of the window
};

std::vector<TilePlace> tile_places(const HeightField& surface) {
  const Eigen::Index cell_rows = surface.rows() - 1, cell_cols = surface.cols() - 1;
  std::vector<TilePlace> result;
  for (Eigen::Index j = 0; j < cell_rows; j += detail::kTileRows)
    for (Eigen::Index i = 0; i < cell_cols; i += detail::kTileCols)
      result.push_back({j, i, std::min(detail::kTileRows, cell_rows - j),
                        std::min(detail::kTileCols, cell_cols - i), static_cast<std::int64_t>(result.size()),
                        j * kParts / cell_rows * kParts + i * kParts / cell_cols});
  return result;
}

/// Least and greatest height that is there, or 0, 0.
struct HeightRange {
  double low = 0, high = 0;
};

HeightRange height_range(const HeightField& piece) {
  float low = INFINITY, high = -INFINITY;
  for (Eigen::Index k = 0; k < piece.z.size(); ++k) {  // comparisons with NaN are false
    const float z = piece.z.data()[k];
    low = z < low ? z : low;
    high = z > high ? z : high;
  }
  return low <= high ? HeightRange{low, high} : HeightRange{};
}

template <typename T>
TriangleTile<T> make_tile(const Window& window, const HeightField& piece, const HeightRange& range,
                          const TilePlace& place, std::uint32_t number) {
  TriangleTile<T> tile;
  const double dx = piece.dx, dy = piece.dy;
  const double middle_x = static_cast<double>(place.cols) / 2, middle_y = static_cast<double>(place.rows) / 2,
               middle_z = (range.low + range.high) / 2;
  tile.centre = {(static_cast<double>(place.col) + middle_x) * dx,
                 (static_cast<double>(place.row) + middle_y) * dy, middle_z};
  tile.first_index = (static_cast<std::uint64_t>(number) << 40) +
                     static_cast<std::uint64_t>(place.number) * detail::kTileTriangles;
  std::size_t n = 0;
  for (Eigen::Index j = 0; j < place.rows; ++j)
    for_each_triangle(piece, j, [&](const Triangle& t) {
      const double amplitude =
          window.taper.size() ? window.taper(place.row + t.a.y(), place.col + t.a.x()) : 1.0;
      tile.x[n] = static_cast<T>((t.a.x() - middle_x) * dx);
      tile.y[n] = static_cast<T>((t.a.y() - middle_y) * dy);
      tile.z[n] = static_cast<T>(piece.z(t.a.y(), t.a.x()) - middle_z);
      tile.bx[n] = static_cast<T>((t.b.x() - t.a.x()) * dx);
      tile.by[n] = static_cast<T>((t.b.y() - t.a.y()) * dy);
      tile.cx[n] = static_cast<T>((t.c.x() - t.a.x()) * dx);
      tile.cy[n] = static_cast<T>((t.c.y() - t.a.y()) * dy);
      tile.zx[n] = static_cast<T>(t.zx);
      tile.zy[n] = static_cast<T>(t.zy);
      tile.weight[n] = static_cast<T>(amplitude * dx * dy / 2);
      ++n;
    });
  tile.count = (n + detail::kLanePadding - 1) / detail::kLanePadding * detail::kLanePadding;
  for (auto* array :
       {&tile.x, &tile.y, &tile.z, &tile.bx, &tile.by, &tile.cx, &tile.cy, &tile.zx, &tile.zy, &tile.weight})
    std::fill(array->begin() + static_cast<std::ptrdiff_t>(n),
              array->begin() + static_cast<std::ptrdiff_t>(tile.count), static_cast<T>(0));
  return tile;
}

/// Adds up b into a.
void add(DrawSums& a, const DrawSums& b) {
  a.draw[0] += b.draw[0];
  a.draw[1] += b.draw[1];
  a.re_re += b.re_re;
  a.re_im += b.re_im;
  a.im_im += b.im_im;
}

template <typename T>
std::vector<DrawSums> tile_sums(const TriangleTile<T>& tile, std::span<const Vec3> q,
                                std::span<const Stratum> cut, PointsPerDraw points) {
  std::vector<DrawSums> result(q.size());
  if (tile.count == 0) return result;
  const auto per_draw = static_cast<std::size_t>(points);
  const auto drawn = hwy::AllocateAligned<T>(2 * per_draw * 3 * detail::kTileTriangles);
  std::vector<DrawSums> sums(q.size());
  for (const Stratum& stratum : cut) {
    detail::draw_points(tile, stratum, points, drawn.get());
    detail::sum_points(tile, points, drawn.get(), q, sums);
    for (std::size_t k = 0; k < q.size(); ++k)
      add(result[k], sums[k]);
  }
  // To the mean over points and strata, and from the tile's centre to the origin; a half's variance is half
  // that of the difference.
  const double scale = 1.0 / static_cast<double>(per_draw * cut.size());
  for (std::size_t k = 0; k < q.size(); ++k) {
    const Complex turn = std::polar(scale, -q[k].dot(tile.centre));
    DrawSums& s = result[k];
    s.draw[0] *= turn;
    s.draw[1] *= turn;
    const double c = turn.real(), n = turn.imag(), a = s.re_re / 2, b = s.re_im / 2, e = s.im_im / 2;
    s.re_re = c * c * a - 2 * c * n * b + n * n * e;
    s.re_im = c * n * (a - e) + (c * c - n * n) * b;
    s.im_im = n * n * a + 2 * c * n * b + c * c * e;
  }
  return result;
}

std::vector<DrawSums> tile_sums(const Window& window, const TilePlace& place, std::span<const Vec3> q,
                                const Vec3& largest, std::span<const Stratum> cut,
                                const FieldSampling& sampling) {
  const HeightField& s = window.surface;
  const HeightField piece{s.z.block(place.row, place.col, place.rows + 1, place.cols + 1), s.dx, s.dy, 0};
  const HeightRange range = height_range(piece);
  const Vec3 extent(static_cast<double>(place.cols) * s.dx, static_cast<double>(place.rows) * s.dy,
                    range.high - range.low);
  const PointsPerDraw points = points_per_draw(sampling.draws);
  return largest.dot(extent) / 2 <= kFloatPhase
             ? tile_sums(make_tile<float>(window, piece, range, place, sampling.window), q, cut, points)
             : tile_sums(make_tile<double>(window, piece, range, place, sampling.window), q, cut, points);
}

/// Tiles in a row of one part, handed out together: [first, last) of the list of places.
struct TileRun {
  std::size_t first, last;
  Eigen::Index part;
};

std::vector<TileRun> tile_runs(std::span<const TilePlace> places) {
  std::vector<TileRun> runs;
  for (std::size_t t = 0; t < places.size(); ++t)
    if (t > 0 && places[t].part == runs.back().part && places[t].row == places[t - 1].row)
      runs.back().last = t + 1;
    else
      runs.push_back({t, t + 1, places[t].part});
  return runs;
}

void add_batch(const Window& window, std::span<const Vec3> q, std::span<const TilePlace> places,
               std::span<const Stratum> cut, const FieldSampling& sampling, std::span<FieldHalves> result) {
  Vec3 largest = Vec3::Zero();
  for (const Vec3& direction : q)
    largest = largest.cwiseMax(direction.cwiseAbs());
  const std::vector<TileRun> runs = tile_runs(places);
  std::vector<std::vector<DrawSums>> run_sums(runs.size());
  parallel_for(static_cast<std::int64_t>(runs.size()), [&](std::int64_t r) {
    const auto run = static_cast<std::size_t>(r);
    std::vector<DrawSums> total(q.size());
    for (std::size_t t = runs[run].first; t < runs[run].last; ++t) {
      const std::vector<DrawSums> sums = tile_sums(window, places[t], q, largest, cut, sampling);
      for (std::size_t k = 0; k < q.size(); ++k)
        add(total[k], sums[k]);
    }
    run_sums[run] = std::move(total);
  });
  std::vector<std::array<Complex, 2>> parts(static_cast<std::size_t>(kParts * kParts) * q.size());
  for (std::size_t run = 0; run < runs.size(); ++run)
    for (std::size_t k = 0; k < q.size(); ++k) {
      const DrawSums& sums = run_sums[run][k];
      auto& part = parts[static_cast<std::size_t>(runs[run].part) * q.size() + k];
      part[0] += sums.draw[0];
      part[1] += sums.draw[1];
      result[k].covariance +=
          (Eigen::Matrix2d() << sums.re_re, sums.re_im, sums.re_im, sums.im_im).finished();
    }
  for (std::size_t p = 0; p < parts.size(); ++p) {
    FieldHalves& halves = result[p % q.size()];
    halves.first += parts[p][0];
    halves.second += parts[p][1];
    halves.incoherent += (parts[p][0] * std::conj(parts[p][1])).real();
  }
}

/// What the rounding of phases in float leaves of the envelope, 1/sr.
double rounding_error(const DirectionEstimate& d) {
  return 1e-6 * std::sqrt(d.local_mean * std::max(d.density, d.local_mean));
}

/// D, its standard error and the local mean from the halves of every window.
/// With F̂₁ = F + a, F̂₂ = F + b, Cov a = Cov b = C as 2×2 matrices over (Re, Im):
/// Var Re(F̂₁F̂₂*) = 2 FᵀCF + tr C². F̄ = (F̂₁+F̂₂)/2 has E F̄ᵀCF̄ = FᵀCF + tr C²/2, so that both terms together are
/// 2 F̄ᵀCF̄, never taken below the part that remains at F = 0.
DirectionEstimate combine(std::span<const FieldHalves> windows, double area) {
  DirectionEstimate result;
  double variance = 0;
  for (const FieldHalves& w : windows) {
    result.density += (w.first * std::conj(w.second)).real();
    result.local_mean += w.incoherent;
    const Complex mean = (w.first + w.second) / 2.0;
    const Vec2 f(mean.real(), mean.imag());
    variance += std::max(2 * f.dot(w.covariance * f), (w.covariance * w.covariance).trace());
  }
  const double unit = 4 * std::numbers::pi * std::numbers::pi * area;
  result.density /= unit;
  result.local_mean = std::max(result.local_mean, 0.0) / unit;
  result.standard_error = std::sqrt(variance) / unit;
  // Without any variance, as on plates, every point has the same phase: none is rounded differently.
  if (variance > 0) result.standard_error = std::hypot(result.standard_error, rounding_error(result));
  return result;
}

/// Whole numbers about a quarter apart, so that directions that need about the same n share their points.
int round_up_subdivision(double n) {
  if (n <= 6) return static_cast<int>(std::ceil(n));
  return static_cast<int>(std::ceil(std::exp2(std::ceil(3 * std::log2(n)) / 3)));
}

/// More would overflow the numbering of strata.
constexpr int kMaxSubdivision = 2000;

struct Problem {
  std::span<const Window> windows;
  std::span<const Vec3> q;
  const MonteCarlo& options;
  double area;                    ///< Σ of the windows' effective areas
  double points_per_subdivision;  ///< points of one direction at n = 1
};

/// Estimates the directions `which` with n² strata.
std::vector<DirectionEstimate> pass(const Problem& problem, std::span<const std::size_t> which, int n) {
  std::vector<Vec3> q;
  for (const std::size_t k : which)
    q.push_back(problem.q[k]);
  const std::size_t windows = problem.windows.size();
  std::vector<FieldHalves> halves(windows * q.size());
  for (std::size_t w = 0; w < windows; ++w) {
    const auto field =
        monte_carlo_field(problem.windows[w], q,
                          {n, problem.options.seed, static_cast<std::uint32_t>(w), problem.options.draws});
    for (std::size_t k = 0; k < q.size(); ++k)
      halves[k * windows + w] = field[k];
  }
  std::vector<DirectionEstimate> result;
  for (std::size_t k = 0; k < q.size(); ++k) {
    DirectionEstimate d = combine({&halves[k * windows], windows}, problem.area);
    d.subdivision = n;
    d.reached = d.standard_error <= problem.options.tolerance * std::max(d.density, d.local_mean);
    result.push_back(d);
  }
  return result;
}

/// The n that should do, from the error at the present one: it falls like n⁻³ when first orders cancel, like
/// n⁻² otherwise (n² strata, each error smaller by 1/n per order of the phase, √n² from averaging).
int next_subdivision(const DirectionEstimate& d, const MonteCarlo& options) {
  const double order = options.draws == Draws::Rotated ? 3 : 2;
  const double wanted = std::max(options.tolerance * std::max(d.density, d.local_mean), rounding_error(d));
  constexpr double kMargin = 1.1;
  const double factor = wanted > 0 ? std::pow(d.standard_error / wanted, 1 / order) * kMargin : 4.0;
  return std::min(round_up_subdivision(std::max(d.subdivision * std::min(factor, 16.0), d.subdivision + 1.0)),
                  kMaxSubdivision);
}

}  // namespace

std::vector<FieldHalves> monte_carlo_field(const Window& window, std::span<const Vec3> q,
                                           const FieldSampling& sampling) {
  std::vector<FieldHalves> result(q.size());
  if (window.surface.rows() < 2 || window.surface.cols() < 2) return result;
  const std::vector<TilePlace> places = tile_places(window.surface);
  const std::vector<Stratum> cut = strata(sampling.subdivision, sampling.seed);
  for (std::size_t begin = 0; begin < q.size(); begin += kDirectionBatch) {
    const std::size_t count = std::min(kDirectionBatch, q.size() - begin);
    add_batch(window, q.subspan(begin, count), places, cut, sampling,
              std::span(result).subspan(begin, count));
  }
  return result;
}

Estimate<std::vector<DirectionEstimate>> monte_carlo_density(std::span<const Window> windows,
                                                             std::span<const Vec3> q,
                                                             const MonteCarlo& options) {
  const Stopwatch watch;
  if (!(options.tolerance > 0))
    throw InputError("the tolerance must be positive, not " + std::to_string(options.tolerance));
  for (const Vec3& direction : q)
    if (!direction.allFinite()) throw InputError("a wave vector is not finite");
  double area = 0, triangles = 0;
  for (const Window& window : windows) {
    area += effective_area(window);
    triangles += static_cast<double>(triangle_count(window.surface));
  }
  if (!(area > 0))
    throw InputError("not one triangle of the surface is there: D_K needs three neighbouring heights");

  const double draws = 2 * static_cast<double>(static_cast<int>(points_per_draw(options.draws)));
  const Problem problem{windows, q, options, area, triangles * draws};
  Estimate<std::vector<DirectionEstimate>> result;
  result.value.resize(q.size());
  double points = 0;
  std::map<int, std::vector<std::size_t>> todo;  // directions by the n to be tried next
  todo[1].resize(q.size());
  std::iota(todo[1].begin(), todo[1].end(), std::size_t{0});
  while (!todo.empty()) {
    int n = todo.begin()->first;
    std::vector<std::size_t> which = std::move(todo.begin()->second);
    todo.erase(todo.begin());
    if (n > 1) {
      // Within what the budget still allows, if that is any better than what is there.
      const double affordable =
          std::sqrt((options.max_points - points) /
                    (problem.points_per_subdivision * static_cast<double>(which.size())));
      if (!(affordable >= n)) n = affordable >= 2 ? static_cast<int>(affordable) : 0;
      std::erase_if(which, [&](std::size_t k) { return result.value[k].subdivision >= n; });
    }
    if (which.empty()) continue;
    const std::vector<DirectionEstimate> estimates = pass(problem, which, n);
    points += problem.points_per_subdivision * n * n * static_cast<double>(which.size());
    for (std::size_t k = 0; k < which.size(); ++k) {
      result.value[which[k]] = estimates[k];
      constexpr double kOfRounding = 1.5;  // all else is gone then
      const bool improvable = estimates[k].standard_error > kOfRounding * rounding_error(estimates[k]);
      if (!estimates[k].reached && improvable && n < kMaxSubdivision)
        todo[next_subdivision(estimates[k], options)].push_back(which[k]);
    }
  }
  double error2 = 0, norm2 = 0;
  for (const DirectionEstimate& d : result.value) {
    error2 += d.standard_error * d.standard_error;
    norm2 += d.density * d.density;
  }
  result.error = error2 > 0 ? std::sqrt(error2 / norm2) : 0;
  result.cost = {watch.seconds(), static_cast<std::int64_t>(std::llround(points))};
  return result;
}

Estimate<std::vector<DirectionEstimate>> monte_carlo_density(const HeightField& surface,
                                                             std::span<const Vec3> q,
                                                             const MonteCarlo& options) {
  const Window window{surface, {}};
  return monte_carlo_density({&window, 1}, q, options);
}

}  // namespace micro
