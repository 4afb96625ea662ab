// Distributions and their fits, one thread. Each case says how far it is from the multiply-adds that it
// cannot do without (a division, a root counts as one), or from the cache lines that it must fetch.
#include <benchmark/benchmark.h>

#include <numbers>

#include "core/parallel.h"
#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "distribution/tabulated.h"
#include "fit/fit.h"
#include "of_bound.h"

namespace micro {
namespace {

const SlopeFrame kFrame = slope_frame({0.3, 0.1, 0.1, -0.05, 0.5});

/// Upper directions, in no order that a cache could like.
std::vector<Vec3> directions(int n) {
  std::vector<Vec3> all;
  for (int k = 0; k < n; ++k) {
    const auto [a, b] = random_uniform(1, 0, static_cast<std::uint64_t>(k));
    const double z = 0.5 + 0.5 * a, r = std::sqrt(1 - z * z), phi = 6.283185307179586 * b;
    all.emplace_back(r * std::cos(phi), r * std::sin(phi), z);
  }
  return all;
}

/// What one call needs of the machine, and what the machine gives a second.
struct Need {
  double amount, bound;
};
/// Into the round lobe's frame, its density there; u' and its area.
Need ellipsoid_dg1() {
  return {22, peak()};
}
/// The same, and an exponential and an error function of some twenty terms each.
Need beckmann_dg1() {
  return {22 + 2 * 20, peak()};
}
/// Into the frame and back, a point on a disk with its sine and cosine.
Need visible_normal() {
  return {60, peak()};
}
/// Two rows of nodes of D and two of the masking table.
Need tabulated() {
  constexpr double cache_line = 64;
  return {4 * cache_line, bandwidth()};
}

/// D(m)·G1(u) for each pair of directions.
template <typename Model>
void evaluate(benchmark::State& state, const Model& model, const Need& need) {
  const std::vector<Vec3> m = directions(4096);
  benchmark::DoNotOptimize(model.G1(m[0]));  // tables that are made when they are first asked for
  const double seconds = seconds_of(state, [&] {
    double sum = 0;
    for (std::size_t k = 0; k < m.size(); ++k)
      sum += model.D(m[k]) * model.G1(m[m.size() - 1 - k]);
    return sum;
  });
  const auto pairs = static_cast<double>(m.size());
  state.counters["D*G1/s"] = benchmark::Counter(pairs, benchmark::Counter::kIsIterationInvariantRate);
  report_bound(state, seconds, pairs * need.amount, need.bound);
}

void BM_EllipsoidDG1(benchmark::State& state) {
  evaluate(state, Ellipsoid(kFrame), ellipsoid_dg1());
}
void BM_BeckmannDG1(benchmark::State& state) {
  evaluate(state, Beckmann(kFrame), beckmann_dg1());
}
void BM_TabulatedDG1(benchmark::State& state) {
  evaluate(state, Tabulated(tabulate(Ellipsoid(kFrame), {1025, 1})), tabulated());
}

template <typename Model>
void sample(benchmark::State& state, const Model& model, const Need& need) {
  const Vec3 u = Vec3(0.6, 0.3, 0.5).normalized();
  benchmark::DoNotOptimize(model.sample_visible(u, {0.5, 0.5}));
  std::uint64_t k = 0;
  const double seconds = seconds_of(state, [&] {
    const auto [a, b] = random_uniform(2, 0, k++);
    return model.sample_visible(u, {a, b});
  });
  report_bound(state, seconds, need.amount, need.bound);
}
void BM_EllipsoidVisibleNormal(benchmark::State& state) {
  sample(state, Ellipsoid(kFrame), visible_normal());
}
void BM_BeckmannVisibleNormal(benchmark::State& state) {
  sample(state, Beckmann(kFrame), visible_normal());
}
void BM_TabulatedVisibleNormal(benchmark::State& state) {
  sample(state, Tabulated(tabulate(Ellipsoid(kFrame), {1025, 1})), tabulated());
}

/// A histogram-like table: an ellipsoid with noise that grows as the root of the density.
DiskTable noisy_table(int size) {
  DiskTable table = tabulate(Ellipsoid(kFrame), {size, 1});
  for (Eigen::Index k = 0; k < table.density.size(); ++k) {
    double& d = table.density.data()[k];
    d = std::max(0., d + 0.1 * std::sqrt(d) * random_normal(3, 0, static_cast<std::uint64_t>(k))[0]);
  }
  return table;
}

/// Multiply-adds of one pass over a table's disk: the model and its five derivatives at a node, and the sums
/// of their products.
double pass_over(int size) {
  constexpr double each = 63;
  return each * std::numbers::pi / 4 * size * size;
}

void fit_tables(benchmark::State& state, FitModel model) {
  set_thread_count(1);
  const DiskTable table = noisy_table(static_cast<int>(state.range(0)));
  int iterations = 0;
  const double seconds = seconds_of(state, [&] { return iterations = fit(table, model).iterations; });
  state.counters["iterations"] = iterations;
  report_bound(state, seconds, iterations * pass_over(table.grid.size), peak());
  set_thread_count(0);
}
void BM_FitEllipsoid(benchmark::State& state) {
  fit_tables(state, FitModel::EllipsoidNdf);
}
void BM_FitBeckmann(benchmark::State& state) {
  fit_tables(state, FitModel::BeckmannNdf);
}

/// One pass over a table: what a step of the fit cannot do without.
void BM_NormalEquations(benchmark::State& state) {
  set_thread_count(1);
  const DiskTable table = noisy_table(1025);
  TableEquations equations(table);
  const double seconds =
      seconds_of(state, [&] { return equations(kFrame, FitModel::EllipsoidNdf, Weighting::SolidAngle); });
  report_bound(state, seconds, pass_over(table.grid.size), peak());
  set_thread_count(0);
}

BENCHMARK(BM_EllipsoidDG1);
BENCHMARK(BM_BeckmannDG1);
BENCHMARK(BM_TabulatedDG1);
BENCHMARK(BM_EllipsoidVisibleNormal);
BENCHMARK(BM_BeckmannVisibleNormal);
BENCHMARK(BM_TabulatedVisibleNormal);
BENCHMARK(BM_FitEllipsoid)->Arg(33)->Arg(65)->Arg(1025)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_FitBeckmann)->Arg(33)->Arg(65)->Arg(1025)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_NormalEquations)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace micro

BENCHMARK_MAIN();
