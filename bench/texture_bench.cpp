// Texels and textures: docs/texture.md quotes these. Each case says how far it is from the multiply-adds that
// it cannot do without.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/parallel.h"
#include "core/random.h"
#include "height/gaussian_surface.h"
#include "ndf/gaussian_passes.h"
#include "of_bound.h"
#include "pipelines/texels_of_surface.h"
#include "texture/synthesis.h"

namespace micro {
namespace {

/// 10,000 texels of 100 × 100 points each, as scans of their own (0) or as blocks of one scan (1).
void texels(benchmark::State& state) {
  constexpr Eigen::Index kSide = 100, kAcross = 100;
  const GaussianField rough = {.rms = 0.3, .tau_x = 3, .tau_y = 3};
  const bool blocks = state.range(0) == 1;
  const Eigen::Index side = blocks ? kSide * kAcross : kSide;
  const HeightField surface = gaussian_surface({side, side, 0.11, 0.11}, rough, 1);
  const double seconds = seconds_of(state, [&] {
    if (blocks) {
      benchmark::DoNotOptimize(texels_of_surface(surface, {kSide, kSide, 1, 0}));
    } else {
      parallel_for(kAcross * kAcross, [&](std::int64_t) {
        benchmark::DoNotOptimize(texels_of_surface(surface, {0, 0, 1, 0}));
      });
    }
    return 0;
  });
  // Its plane fits: two separable convolutions.
  const double points = kSide * kSide * kAcross * kAcross;
  report_bound(state, seconds, 4 * points * static_cast<double>(GaussianTaps(0.11, 1, kSide).size()), peak());
}
BENCHMARK(texels)
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Iterations(1);

Exemplar two_strips() {
  Exemplar exemplar = make_exemplar(100, 100);
  for (std::size_t c = 0; c < kChannels; ++c)
    for (Eigen::Index k = 0; k < 100; ++k) {
      const auto [a, b] = random_normal(1, static_cast<std::uint32_t>(c), static_cast<std::uint64_t>(k));
      exemplar.channels[c](50, k) = a;
      exemplar.channels[c](k, 50) = b;
    }
  return exemplar;
}

constexpr TextureSize kLarge = {4096, 4096};

/// What the inverse transforms of all channels cannot do without, in multiply-adds of doubles; floats go
/// twice as many at a time.
double inverse_transforms(double values) {
  return kChannels * 1.25 * values * std::log2(values) / 2;
}
constexpr double kLargeValues = double{kLarge.rows} * kLarge.cols;

/// 4096² texels × 5, separable, without writing.
void separable(benchmark::State& state) {
  const TextureModel model = model_of(two_strips(), Recipe::Separable);
  const double seconds = seconds_of(state, [&] { return synthesise(model, kLarge, 1); });
  report_bound(state, seconds, inverse_transforms(kLargeValues), peak());
}
BENCHMARK(separable)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime()->Iterations(3);

/// The five inverse transforms of that alone.
void transforms(benchmark::State& state) {
  const RealFft<float> transform({kLarge.rows, kLarge.cols, 1});
  std::vector<FftVector<std::complex<float>>> spectra(kChannels);
  std::vector<FftVector<float>> values(kChannels);
  for (std::size_t c = 0; c < kChannels; ++c) {
    spectra[c].assign(static_cast<std::size_t>(transform.shape().half_size()), 1.F);
    values[c].resize(static_cast<std::size_t>(kLarge.rows * kLarge.cols));
  }
  const double seconds = seconds_of(state, [&] {
    parallel_for(kChannels, [&](std::int64_t c) {
      const auto k = static_cast<std::size_t>(c);
      transform.backward(spectra[k].data(), values[k].data());
    });
    return values[0][0];
  });
  report_bound(state, seconds, inverse_transforms(kLargeValues), peak());
}
BENCHMARK(transforms)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime()->Iterations(3);

/// 2048² texels of a texture of 16384², by parts.
void part(benchmark::State& state) {
  const TextureModel model = model_of(two_strips(), Recipe::Separable);
  const double seconds = seconds_of(state, [&] {
    return synthesise_part(model, {16384, 16384}, 1, {4096, 2048, 2048, 2048});
  });
  report_bound(state, seconds, 2 * inverse_transforms(2048. * 2048), peak());  // there and back
}
BENCHMARK(part)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime()->Iterations(3);

/// Slope coordinates to widths and angles, 10⁶ texels.
void parameters(benchmark::State& state) {
  const TextureField field = synthesise(model_of(two_strips(), Recipe::Separable), {1000, 1000}, 1);
  const double seconds = seconds_of(state, [&] {
    parallel_for(1000, [&](std::int64_t j) {
      for (Eigen::Index i = 0; i < 1000; ++i)
        benchmark::DoNotOptimize(
            canonical_parameters(frame_of({0.1 * field[0](j, i), 0.1 * field[1](j, i), field[2](j, i) - 2,
                                           field[3](j, i), field[4](j, i) - 2})));
    });
    return 0;
  });
  constexpr double each = 60 + 4 * 20;  // a symmetric 3 × 3 eigenproblem, four arctangents
  report_bound(state, seconds, each * 1e6, peak());
}
BENCHMARK(parameters)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime()->Iterations(3);

}  // namespace
}  // namespace micro

BENCHMARK_MAIN();
