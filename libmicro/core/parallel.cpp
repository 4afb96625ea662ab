#include "core/parallel.h"

#include <atomic>
#include <exception>
#include <mutex>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace micro {

#ifdef _OPENMP
int thread_count() {
  return omp_in_parallel() ? 1 : omp_get_max_threads();
}

void set_thread_count(int n) {
  omp_set_num_threads(n > 0 ? n : omp_get_num_procs());
}
#else
int thread_count() {
  return 1;
}

void set_thread_count(int) {}
#endif

namespace {

/// Keeps the first exception of a parallel region: nothing may throw out of an OpenMP region.
class FirstException {
 public:
  template <typename Call>
  void guard(Call&& call) {
    if (caught_) return;
    try {
      call();
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!exception_) exception_ = std::current_exception();
      caught_ = true;
    }
  }
  void rethrow() const {
    if (exception_) std::rethrow_exception(exception_);
  }

 private:
  std::atomic<bool> caught_ = false;
  std::mutex mutex_;
  std::exception_ptr exception_;
};

}  // namespace

namespace detail {

void parallel_for(std::int64_t n, const std::function<void(std::int64_t)>& body) {
  FirstException first;
#pragma omp parallel for schedule(dynamic, 1) if (n > 1)
  for (std::int64_t i = 0; i < n; ++i)
    first.guard([&] { body(i); });
  first.rethrow();
}

void parallel_in_order(std::int64_t n, const std::function<std::shared_ptr<void>(std::int64_t)>& produce,
                       const std::function<void(std::int64_t, void*)>& consume) {
  FirstException first;
#pragma omp parallel for ordered schedule(dynamic, 1) if (n > 1)
  for (std::int64_t i = 0; i < n; ++i) {
    std::shared_ptr<void> result;
    first.guard([&] { result = produce(i); });
#pragma omp ordered
    first.guard([&] { consume(i, result.get()); });
  }
  first.rethrow();
}

}  // namespace detail
}  // namespace micro
