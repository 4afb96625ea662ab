// A fit takes its memory before it iterates: the same number of blocks from a near start and from a far one.
#include <atomic>
#include <cstdio>
#include <cstdlib>

#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "fit/fit.h"
#include "fit/slope_fit.h"

namespace {
std::atomic<long> blocks{0};
}  // namespace

// What operator new and Eigen both end in.
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) noexcept {
  ++blocks;
  return __libc_malloc(size);
}

namespace {
using namespace micro;

/// Iterations and blocks of memory of a fit.
struct Course {
  int iterations;
  long blocks;
};
template <typename Fitting>
Course course_of(const char* what, Fitting&& fitting) {
  const long before = blocks;
  const int iterations = fitting().iterations;
  const Course course{iterations, blocks - before};
  std::printf("%s: %d iterations, %ld blocks\n", what, course.iterations, course.blocks);
  return course;
}
/// One that iterates more takes no more blocks.
bool no_more(const Course& near, const Course& far) {
  return near.blocks > 0 && far.iterations > near.iterations && far.blocks <= near.blocks;
}

template <typename Model>
bool tables_take_none(const char* what, FitModel model) {
  const SlopeFrame truth = slope_frame({0.3, 0.15, 0.1, -0.05, 0.6});
  const DiskTable table = tabulate(Model(truth), {33, 1});
  const auto from = [&](const SlopeFrame& start) {
    return course_of(what, [&] { return fit_from(start, 1e-6, table, model); });
  };
  from({{0, 0}, 0.2, 0, 0.2});  // what is taken once
  return no_more(from(truth), from({{0.3, 0.3}, 0.5, 0, 0.5}));
}

/// Slopes of a texel, of an ellipsoid or of two side by side, for which the fit takes longer.
bool texels_take_none() {
  const auto from = [&](double apart) {
    Grid<double> x(64, 64), y(64, 64);
    const Ellipsoid lobe(slope_frame({0.3, 0.1, 0, 0, 0.6}));
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const auto [a, b] = random_uniform(1, 0, static_cast<std::uint64_t>(k));
      const Vec2 slope = slope_of(lobe.sample({a, b}));
      x.data()[k] = slope.x() + (k % 5 == 0 ? apart : 0);
      y.data()[k] = slope.y();
    }
    return course_of("slopes", [&] { return fit_slopes(x, y); });
  };
  from(0);
  return no_more(from(0), from(1.5));
}
}  // namespace

int main() {
  const bool none = tables_take_none<Ellipsoid>("ellipsoid", FitModel::EllipsoidNdf) &&
                    tables_take_none<Beckmann>("Beckmann", FitModel::BeckmannNdf) && texels_take_none();
  return none ? EXIT_SUCCESS : EXIT_FAILURE;
}
