// Monte Carlo D_K: time of a point against the arithmetic bound, and error against run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "../bench/monte_carlo_bench.cpp"  // as seen from libmicro/
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace micro::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Twelve independent chains of multiply-adds, more than latency times pipes anywhere: what the machine can
/// do in float. Returns how many were done.
double MultiplyAdds(float* out) {
  const hn::ScalableTag<float> d;
  using V = hn::Vec<decltype(d)>;
  const V a = hn::Set(d, out[0]), b = hn::Set(d, out[1]);
  const auto start = [&](float k)
                         HWY_ATTR { return hn::Set(d, k * out[0]); };  // all different, or they'd be merged
  V x0 = start(0), x1 = start(1), x2 = start(2), x3 = start(3), x4 = start(4), x5 = start(5), x6 = start(6),
    x7 = start(7), x8 = start(8), x9 = start(9), xa = start(10), xb = start(11);
  constexpr int kRounds = 20000;
  for (int k = 0; k < kRounds; ++k) {
    x0 = hn::MulAdd(x0, a, b), x1 = hn::MulAdd(x1, a, b), x2 = hn::MulAdd(x2, a, b),
    x3 = hn::MulAdd(x3, a, b);
    x4 = hn::MulAdd(x4, a, b), x5 = hn::MulAdd(x5, a, b), x6 = hn::MulAdd(x6, a, b),
    x7 = hn::MulAdd(x7, a, b);
    x8 = hn::MulAdd(x8, a, b), x9 = hn::MulAdd(x9, a, b), xa = hn::MulAdd(xa, a, b),
    xb = hn::MulAdd(xb, a, b);
  }
  const V sum =
      hn::Add(hn::Add(hn::Add(hn::Add(x0, x1), hn::Add(x2, x3)), hn::Add(hn::Add(x4, x5), hn::Add(x6, x7))),
              hn::Add(hn::Add(x8, x9), hn::Add(xa, xb)));
  out[2] = hn::GetLane(hn::SumOfLanes(d, sum));
  return 12.0 * kRounds * static_cast<double>(hn::Lanes(d));
}

}  // namespace micro::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/parallel.h"
#include "core/random.h"
#include "height/height_field.h"
#include "kirchhoff/exact.h"
#include "kirchhoff/monte_carlo.h"

namespace micro {
HWY_EXPORT(MultiplyAdds);
double multiply_adds(float* out) {
  return HWY_DYNAMIC_DISPATCH(MultiplyAdds)(out);
}
}  // namespace micro

namespace {

using namespace micro;

void machine_multiply_adds(benchmark::State& state) {
  float numbers[3] = {0.999f, 1e-3f, 0};
  double done = 0;
  for (auto _ : state) {
    done += multiply_adds(numbers);
    benchmark::DoNotOptimize(numbers[2]);
  }
  state.counters["Gmuladd_per_cpu_s"] = benchmark::Counter(done / 1e9, benchmark::Counter::kIsRate);
}
BENCHMARK(machine_multiply_adds);

/// 640 × 480 at 0.11 µm, σ = 0.3 µm, τ = 3 µm: a sum of 400 waves with Gaussian wave vectors, close to
/// Gaussian.
HeightField reference_surface() {
  constexpr double kPitch = 0.11, kSigma = 0.3, kTau = 3;
  constexpr int kWaves = 400;
  Eigen::ArrayXXd x = Eigen::ArrayXd::LinSpaced(640, 0, 639).matrix().transpose().array() * kPitch,
                  y = Eigen::ArrayXd::LinSpaced(480, 0, 479) * kPitch;
  Grid<double> z = Grid<double>::Zero(480, 640);
  for (int w = 0; w < kWaves; ++w) {
    const auto [u, v] = random_normal(1, 0, static_cast<std::uint64_t>(w));
    const double phase = 2 * M_PI * random_uniform(1, 1, static_cast<std::uint64_t>(w))[0];
    const double kx = u * std::sqrt(2.0) / kTau, ky = v * std::sqrt(2.0) / kTau;
    const Eigen::ArrayXXd a = kx * x + phase, b = ky * y;
    z += (b.cos().matrix() * a.cos().matrix() - b.sin().matrix() * a.sin().matrix()).array();
  }
  return make_height_field(z * (kSigma * std::sqrt(2.0 / kWaves)), kPitch, kPitch);
}

/// Directions as the surface's lobe (slopes of 0.14 each way) spreads them.
std::vector<Vec3> lobe_directions(std::int64_t n) {
  std::vector<Vec3> q;
  for (std::int64_t k = 0; k < n; ++k) {
    const auto [u, v] = random_normal(2, 0, static_cast<std::uint64_t>(k));
    q.push_back(wave_vector(Vec3(-0.14 * u, -0.14 * v, 1).normalized(), 0.555));
  }
  return q;
}

/// Operations on the multiply-add pipes for a triangle and direction: 15 a point (3 for the phase,
/// 10 for the two polynomials, 2 for the sum), 3 for the weight, 3 for the covariance. Two of these start in
/// a cycle, 8 lanes each, on every core with AVX2 of the last ten years.
double multiply_adds_per_point(int points_per_draw) {
  return 15 + 6.0 / (2 * points_per_draw);
}

void point_rate(benchmark::State& state, Draws draws) {
  set_thread_count(static_cast<int>(state.range(1)));
  const Window window{reference_surface(), {}};
  const auto q = lobe_directions(state.range(0));
  const int points_per_draw = draws == Draws::Rotated ? 3 : 1;
  double points = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(monte_carlo_field(window, q, {1, 7, 0, draws}));
    points += 2.0 * points_per_draw * 2 * 479 * 639 * static_cast<double>(q.size());
  }
  using benchmark::Counter;
  state.counters["ns_per_point"] = Counter(points / 1e9, Counter::kIsRate | Counter::kInvert);
  state.counters["ms_per_direction"] =
      Counter(static_cast<double>(q.size()) * static_cast<double>(state.iterations()) / 1e3,
              Counter::kIsRate | Counter::kInvert);
  state.counters["Gmuladd_per_cpu_s"] =
      Counter(points * multiply_adds_per_point(points_per_draw) / 1e9, Counter::kIsRate);
}
BENCHMARK_CAPTURE(point_rate, single, Draws::Single)
    ->ArgsProduct({{1, 16, 128}, {1}})
    ->ArgsProduct({{128}, {2}})
    ->ArgNames({"directions", "threads"})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(point_rate, rotated, Draws::Rotated)
    ->ArgsProduct({{1, 16, 128}, {1}})
    ->ArgsProduct({{128}, {2}})
    ->ArgNames({"directions", "threads"})
    ->Unit(benchmark::kMillisecond);

/// Tolerance 10^−range(0): the error reached against `exact`, and the standard errors it promised.
void error_against_time(benchmark::State& state, Draws draws) {
  set_thread_count(2);
  const HeightField surface = reference_surface();
  const auto q = lobe_directions(32);
  const auto exact = exact_field(surface, q);
  const double area = kirchhoff_area(surface);
  const double tolerance = std::pow(10.0, -static_cast<double>(state.range(0)) / 2);
  double error2 = 0, norm2 = 0, z2 = 0, reached = 0, subdivision = 0;
  Estimate<std::vector<DirectionEstimate>> estimate;
  for (auto _ : state)
    estimate = monte_carlo_density(surface, q, {.tolerance = tolerance, .seed = 3, .draws = draws});
  for (std::size_t k = 0; k < q.size(); ++k) {
    const DirectionEstimate& d = estimate.value[k];
    const double truth = kirchhoff_density(exact[k], area), error = d.density - truth;
    error2 += error * error;
    norm2 += truth * truth;
    z2 += error * error / (d.standard_error * d.standard_error);
    reached += d.reached;
    subdivision += d.subdivision;
  }
  const double n = static_cast<double>(q.size());
  state.counters["ms_per_direction"] = estimate.cost.seconds * 1e3 / n;
  state.counters["rel_L2_error"] = std::sqrt(error2 / norm2);
  state.counters["promised"] = estimate.error;
  state.counters["mean_z2"] = z2 / n;
  state.counters["reached"] = reached / n;
  state.counters["mean_n"] = subdivision / n;
}
BENCHMARK_CAPTURE(error_against_time, single, Draws::Single)
    ->DenseRange(1, 5)
    ->ArgName("tol=10^-x/2")
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(error_against_time, rotated, Draws::Rotated)
    ->DenseRange(1, 8)
    ->ArgName("tol=10^-x/2")
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void exact_rate(benchmark::State& state) {
  set_thread_count(2);
  const HeightField surface = reference_surface();
  const auto q = lobe_directions(32);
  for (auto _ : state)
    benchmark::DoNotOptimize(exact_field(surface, q));
  state.counters["ms_per_direction"] =
      benchmark::Counter(32.0 * static_cast<double>(state.iterations()) / 1e3,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(exact_rate)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
#endif
