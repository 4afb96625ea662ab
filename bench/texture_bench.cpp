// Texels and textures: docs/texture.md quotes these.
#include <benchmark/benchmark.h>

#include "core/parallel.h"
#include "height/gaussian_surface.h"
#include "pipelines/texels_of_surface.h"

namespace micro {
namespace {

/// 10,000 texels of 100 × 100 points each, as scans of their own (0) or as blocks of one scan (1).
void texels(benchmark::State& state) {
  constexpr Eigen::Index kSide = 100, kAcross = 100;
  const GaussianField rough = {.rms = 0.3, .tau_x = 3, .tau_y = 3};
  const bool blocks = state.range(0) == 1;
  const Eigen::Index side = blocks ? kSide * kAcross : kSide;
  const HeightField surface = gaussian_surface({side, side, 0.11, 0.11}, rough, 1);
  for (auto _ : state) {
    if (blocks) {
      benchmark::DoNotOptimize(texels_of_surface(surface, {kSide, kSide, 1, 0}));
    } else {
      parallel_for(kAcross * kAcross, [&](std::int64_t) {
        benchmark::DoNotOptimize(texels_of_surface(surface, {0, 0, 1, 0}));
      });
    }
  }
}
BENCHMARK(texels)
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Iterations(1);

}  // namespace
}  // namespace micro

BENCHMARK_MAIN();
