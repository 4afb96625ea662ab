#pragma once

#include <benchmark/benchmark.h>

#include <ctime>

#include "core/memory.h"
#include "machine_bounds.h"

namespace micro {

/// Multiply-adds of doubles a second, measured once in a run.
inline double peak() {
  static const double measured = peak_multiply_adds();
  return measured;
}

/// Bytes copied a second, measured once in a run.
inline double bandwidth() {
  static const double measured = copy_bandwidth();
  return measured;
}

/// Runs the case; processor seconds of one iteration, of all its threads together. The bounds are those of
/// one thread, so they hold against these. Memory is kept from one to the next, as from scan to scan.
template <typename Body>
double seconds_of(benchmark::State& state, Body&& body) {
  keep_freed_memory();
  const std::clock_t start = std::clock();
  for (auto _ : state)
    benchmark::DoNotOptimize(body());
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / static_cast<double>(state.iterations());
}

/// How far a case is from the bound of its kind, `needed` operations or bytes at `bound` a second: "of bound"
/// = 1 is as fast as the machine can.
inline void report_bound(benchmark::State& state, double seconds, double needed, double bound) {
  state.counters["of bound"] = needed / bound / seconds;
}

}  // namespace micro
