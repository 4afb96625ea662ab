// Geometric NDFs of one scan of 640 × 480 points, one thread. Each case says how far it is from the bound of
// its kind, measured in the same run: multiply-adds it cannot do without against the machine's peak, or bytes
// it must move against a plain copy; and the filtered ones, how many times the literal fit takes.
#include <benchmark/benchmark.h>

#include <Eigen/Dense>
#include <cmath>
#include <ctime>
#include <numbers>
#include <vector>

#include "core/parallel.h"
#include "core/random.h"
#include "distribution/ring_convolution.h"
#include "ndf/gaussian_passes.h"
#include "ndf/normal_counts.h"
#include "of_bound.h"

namespace micro {
namespace {

constexpr int kRows = 480, kCols = 640;
constexpr double kPitch = 0.11, kSigma = 1;
constexpr double kPoints = double{kRows} * kCols;
const DiskGrid kGrid{1025, 1};

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

/// Seconds of the literal weighted fit of all of a scan's points: the nine moments of each window to ±7σ,
/// term by term with tabulated weights, and a 3×3 solve; measured on a few points and scaled.
double literal_seconds(const HeightField& surface) {
  constexpr int kRadius = 64, kMeasured = 20;
  std::vector<double> g;
  for (int t = -kRadius; t <= kRadius; ++t)
    g.push_back(std::exp(-std::pow(t * kPitch / kSigma, 2) / 2));
  const std::clock_t start = std::clock();
  for (int k = 0; k < kMeasured; ++k) {
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    Eigen::Vector3d heights = Eigen::Vector3d::Zero();
    for (int t = -kRadius; t <= kRadius; ++t)
      for (int s = -kRadius; s <= kRadius; ++s) {
        const double z = surface.z(kRows / 2 + t, kCols / 2 + k + s);
        if (std::isnan(z)) continue;
        const double w = g[static_cast<std::size_t>(t + kRadius)] * g[static_cast<std::size_t>(s + kRadius)];
        const Eigen::Vector3d p(1, s * kPitch, t * kPitch);
        moments += w * p * p.transpose();
        heights += w * z * p;
      }
    benchmark::DoNotOptimize(moments.ldlt().solve(heights).eval());
  }
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC * kPoints / kMeasured;
}

/// Multiply-adds that the fits cannot do without: two convolutions per point, each separable into two passes,
/// of which the row passes share their input; nine moments with holes (two row passes of the heights, nine
/// column passes; the mask's row passes see the few missing points alone).
void filtered(benchmark::State& state, double holes, double passes) {
  set_thread_count(1);
  const HeightField surface = scan(holes);
  const double seconds =
      seconds_of(state, [&] { return filtered_counts(local_planes(surface, kSigma), kGrid); });
  const double taps = static_cast<double>(GaussianTaps(kPitch, kSigma, kCols).size());
  report_bound(state, seconds, passes * kPoints * taps, peak());
  state.counters["literal/this"] = literal_seconds(surface) / seconds;
}

void BM_FilteredClean(benchmark::State& state) {
  filtered(state, 0, 4);
}
void BM_FilteredHoles(benchmark::State& state) {
  filtered(state, 0.04, 11);
}

/// Reads the heights, and zeroes and fills a table of counts.
void BM_Naive(benchmark::State& state) {
  set_thread_count(1);
  const HeightField surface = scan(0);
  const double seconds = seconds_of(state, [&] { return naive_counts(surface, kGrid); });
  const double nodes = static_cast<double>(kGrid.size) * kGrid.size;
  report_bound(state, seconds, sizeof(float) * kPoints + sizeof(std::uint32_t) * (nodes + 2 * 2 * kPoints),
               bandwidth());
}

/// A table that fills the disk, under a signature of state.range(0)/10 degrees. It needs six by six points
/// for each node twice and a third time for the hemisphere's, and the transforms of the pairs of rings in
/// reach of each other (n log₂ n multiply-adds of n points), once whole and once of a quarter.
void BM_Signature(benchmark::State& state) {
  set_thread_count(1);
  DiskTable table = make_disk_table(kGrid);
  for (Eigen::Index j = 0; j < kGrid.size; ++j)
    for (Eigen::Index i = 0; i < kGrid.size; ++i)
      if (kGrid.mz2(j, i) > 0) table.density(j, i) = 1 + kGrid.mz2(j, i);
  const double fwhm = static_cast<double>(state.range(0)) / 10 * std::numbers::pi / 180;
  const Signature signature = gaussian_signature(fwhm);
  const double seconds = seconds_of(state, [&] { return convolve(table, signature); });
  const double spacing = ring_spacing(signature).value();
  const double rings = std::numbers::pi / 2 / spacing, around = 4 * rings;
  const double pairs = rings * signature.angle.back() / spacing;
  const double nodes = std::numbers::pi / 4 * kGrid.size * kGrid.size;
  report_bound(state, seconds, 36 * 2.25 * nodes + 1.25 * pairs * around * std::log2(around), peak());
}

BENCHMARK(BM_FilteredClean)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_FilteredHoles)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Naive)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Signature)->Arg(15)->Arg(90)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace micro

BENCHMARK_MAIN();
