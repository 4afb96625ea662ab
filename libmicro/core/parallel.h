#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

namespace micro {

/// How many threads the loops below may use; 1 without OpenMP.
int thread_count();

/// Sets how many threads the loops below may use; n ≤ 0 asks for one per processor.
void set_thread_count(int n);

namespace detail {
void parallel_for(std::int64_t n, const std::function<void(std::int64_t)>& body);
void parallel_in_order(std::int64_t n, const std::function<std::shared_ptr<void>(std::int64_t)>& produce,
                       const std::function<void(std::int64_t, void*)>& consume);
}  // namespace detail

/// Calls body(i) for i in [0, n) on all threads, in no particular order; inside another parallel loop it runs
/// serially. The first exception thrown by a body is rethrown here after every thread has stopped.
/// One body should be worth some microseconds: hand out rows or blocks, not elements.
template <typename Body>
void parallel_for(std::int64_t n, Body&& body) {
  detail::parallel_for(n, std::function<void(std::int64_t)>(std::ref(body)));
}

/// Cuts [0, n) into blocks of `grain` and calls body(begin, end) for each. The cut depends on n and grain
/// alone, so sums kept per block and added in block order are the same for any number of threads.
template <typename Body>
void parallel_blocks(std::int64_t n, std::int64_t grain, Body&& body) {
  parallel_for((n + grain - 1) / grain, [&](std::int64_t block) {
    const std::int64_t begin = block * grain;
    body(begin, begin + grain < n ? begin + grain : n);
  });
}

/// Calls produce(i) on all threads and consume(i, result) one at a time in the order of i: a stream whose
/// outcome does not depend on the number of threads and which holds no more results than there are threads.
template <typename Produce, typename Consume>
void parallel_in_order(std::int64_t n, Produce&& produce, Consume&& consume) {
  using Result = decltype(produce(std::int64_t{}));
  detail::parallel_in_order(
      n, [&](std::int64_t i) { return std::make_shared<Result>(produce(i)); },
      [&](std::int64_t i, void* result) { consume(i, std::move(*static_cast<Result*>(result))); });
}

}  // namespace micro
