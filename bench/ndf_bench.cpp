#include <benchmark/benchmark.h>

#include "core/parallel.h"
#include "core/random.h"
#include "ndf/gaussian_passes.h"
#include "ndf/normal_counts.h"

namespace micro {
namespace {

constexpr int kRows = 480, kCols = 640;
constexpr double kPitch = 0.11, kSigma = 1;

/// 640×480 at 0.11 µm; `holes` of its points missing at random. The time of a fit does not depend on the
/// heights.
HeightField scan(double holes) {
  Grid<double> z(kRows, kCols);
  for (int k = 0; k < z.size(); ++k) {
    const auto index = static_cast<std::uint64_t>(k);
    z.data()[k] = random_uniform(1, 1, index)[0] < holes ? kMissing : 0.05 * random_normal(1, 0, index)[0];
  }
  return make_height_field(z, kPitch, kPitch);
}

/// Multiply-adds that the fits cannot do without: two convolutions per point, each separable into two passes,
/// of which the row passes share their input; nine moments with holes (five row passes, nine column passes).
double multiply_adds(const HeightField& surface, double passes) {
  return passes * static_cast<double>(surface.z.size()) *
         static_cast<double>(GaussianTaps(kPitch, kSigma, kCols).size());
}

void filtered(benchmark::State& state, double holes, double passes) {
  set_thread_count(1);
  const HeightField surface = scan(holes);
  for (auto _ : state)
    benchmark::DoNotOptimize(filtered_counts(local_planes(surface, kSigma), {1025, 1}));
  state.counters["GFMA/s"] = benchmark::Counter(multiply_adds(surface, passes) * 1e-9,
                                                benchmark::Counter::kIsIterationInvariantRate);
}

void BM_FilteredClean(benchmark::State& state) {
  filtered(state, 0, 4);
}
void BM_FilteredHoles(benchmark::State& state) {
  filtered(state, 0.04, 14);
}
void BM_Naive(benchmark::State& state) {
  const HeightField surface = scan(0);
  for (auto _ : state)
    benchmark::DoNotOptimize(naive_counts(surface, {1025, 1}));
  state.counters["triangles/s"] =
      benchmark::Counter(2. * (kRows - 1) * (kCols - 1), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(BM_FilteredClean)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_FilteredHoles)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Naive)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace micro

BENCHMARK_MAIN();
