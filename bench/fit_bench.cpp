#include <benchmark/benchmark.h>

#include "core/parallel.h"
#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "distribution/tabulated.h"
#include "fit/fit.h"

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

/// D(m)·G1(u) for each pair of directions.
template <typename Model>
void evaluate(benchmark::State& state, const Model& model) {
  const std::vector<Vec3> m = directions(4096);
  benchmark::DoNotOptimize(model.G1(m[0]));  // tables that are made when they are first asked for
  for (auto _ : state) {
    double sum = 0;
    for (std::size_t k = 0; k < m.size(); ++k)
      sum += model.D(m[k]) * model.G1(m[m.size() - 1 - k]);
    benchmark::DoNotOptimize(sum);
  }
  state.counters["D*G1/s"] =
      benchmark::Counter(static_cast<double>(m.size()), benchmark::Counter::kIsIterationInvariantRate);
}

void BM_EllipsoidDG1(benchmark::State& state) {
  evaluate(state, Ellipsoid(kFrame));
}
void BM_BeckmannDG1(benchmark::State& state) {
  evaluate(state, Beckmann(kFrame));
}
void BM_TabulatedDG1(benchmark::State& state) {
  evaluate(state, Tabulated(tabulate(Ellipsoid(kFrame), {1025, 1})));
}

template <typename Model>
void sample(benchmark::State& state, const Model& model) {
  const Vec3 u = Vec3(0.6, 0.3, 0.5).normalized();
  benchmark::DoNotOptimize(model.sample_visible(u, {0.5, 0.5}));
  std::uint64_t k = 0;
  for (auto _ : state) {
    const auto [a, b] = random_uniform(2, 0, k++);
    benchmark::DoNotOptimize(model.sample_visible(u, {a, b}));
  }
}
void BM_EllipsoidVisibleNormal(benchmark::State& state) {
  sample(state, Ellipsoid(kFrame));
}
void BM_BeckmannVisibleNormal(benchmark::State& state) {
  sample(state, Beckmann(kFrame));
}
void BM_TabulatedVisibleNormal(benchmark::State& state) {
  sample(state, Tabulated(tabulate(Ellipsoid(kFrame), {1025, 1})));
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

void fit_tables(benchmark::State& state, FitModel model) {
  set_thread_count(1);
  const DiskTable table = noisy_table(static_cast<int>(state.range(0)));
  int iterations = 0;
  for (auto _ : state)
    iterations = fit(table, model).iterations;
  state.counters["iterations"] = iterations;
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
  for (auto _ : state)
    benchmark::DoNotOptimize(equations(kFrame, FitModel::EllipsoidNdf, Weighting::SolidAngle));
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
