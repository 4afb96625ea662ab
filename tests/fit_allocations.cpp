// A fit takes its memory before it iterates: the same number of blocks from a near start and from a far one.
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "fit/fit.h"

namespace {
std::atomic<long> blocks{0};
}  // namespace

// What operator new and Eigen both end in.
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) noexcept {
  ++blocks;
  return __libc_malloc(size);
}

int main() {
  using namespace micro;
  const DiskTable table = tabulate(Ellipsoid(slope_frame({0.3, 0.15, 0.1, -0.05, 0.6})), {33, 1});
  const auto blocks_from = [&](const SlopeFrame& start) {
    const long before = blocks;
    const Fit found = fit_from(start, 1e-6, table, FitModel::EllipsoidNdf);
    std::printf("%d iterations, %ld blocks\n", found.iterations, blocks - before);
    return std::pair(found.iterations, blocks - before);
  };
  blocks_from({{0, 0}, 0.2, 0, 0.2});  // what is taken once
  const auto near = blocks_from(slope_frame({0.3, 0.15, 0.1, -0.05, 0.6}));
  const auto far = blocks_from({{0.3, 0.3}, 0.5, 0, 0.5});
  return near.second > 0 && far.first > near.first + 3 && far.second == near.second ? EXIT_SUCCESS
                                                                                    : EXIT_FAILURE;
}
