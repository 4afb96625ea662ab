#pragma once

#include <chrono>
#include <cstdint>

namespace micro {

/// What a number cost: wall-clock seconds and the elementary evaluations behind it (the estimator says
/// which).
struct Cost {
  double seconds = 0;
  std::int64_t evaluations = 0;
};

/// A value, the error reached (in the measure that the estimator documents) and what it cost.
template <typename T>
struct Estimate {
  T value;
  double error = 0;
  Cost cost;
};

/// Wall-clock time since it was made, in seconds.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(clock::now() - start_).count(); }

 private:
  using clock = std::chrono::steady_clock;
  clock::time_point start_ = clock::now();
};

}  // namespace micro
