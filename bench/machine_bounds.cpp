#include "machine_bounds.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include "core/estimate.h"

// Highway compiles this file once for each instruction set and picks the best one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "machine_bounds.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace micro::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kSums = 10;  // independent, so that no multiply-add waits for another

/// `rounds` times kSums vectors of multiply-adds; their number is returned, their outcome goes to `out`.
double MultiplyAdds(std::size_t rounds, double factor, double* out) {
  const hn::ScalableTag<double> d;
  const auto a = hn::Set(d, factor), b = hn::Set(d, 1 - factor);
  hn::Vec<decltype(d)> sum[kSums];
  for (std::size_t k = 0; k < kSums; ++k)
    sum[k] = hn::Set(d, static_cast<double>(k));
  for (std::size_t round = 0; round < rounds; ++round)
    for (auto& s : sum)
      s = hn::MulAdd(s, a, b);
  for (std::size_t k = 1; k < kSums; ++k)
    sum[0] = hn::Add(sum[0], sum[k]);
  *out = hn::GetLane(sum[0]);
  return static_cast<double>(rounds * kSums * hn::Lanes(d));
}

}  // namespace micro::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace micro {
HWY_EXPORT(MultiplyAdds);

namespace {

/// Enough that other programs leave one of them alone.
constexpr int kRuns = 7;

volatile double sink;  // what is never read would not be computed

}  // namespace

double peak_multiply_adds() {
  constexpr std::size_t kRounds = 2'000'000;
  double most = 0;
  for (int run = 0; run < kRuns; ++run) {
    double out = 0;
    const Stopwatch watch;
    const double count = HWY_DYNAMIC_DISPATCH(MultiplyAdds)(kRounds, 0.5 + 1e-3 * run, &out);
    most = std::max(most, count / watch.seconds());
    sink = out;
  }
  return most;
}

double copy_bandwidth() {
  constexpr std::size_t kBytes = std::size_t{256} << 20;
  const std::vector<char> from(kBytes, 1);
  std::vector<char> to(kBytes);
  double most = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Stopwatch watch;
    std::memcpy(to.data(), from.data(), kBytes);
    most = std::max(most, 2 * static_cast<double>(kBytes) / watch.seconds());
    sink = to[kBytes / 2];
  }
  return most;
}

}  // namespace micro
#endif
