#include "core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <vector>

namespace micro {
namespace {

TEST(Parallel, VisitsEveryIndexOnce) {
  std::vector<std::atomic<int>> visits(1000);
  parallel_for(1000, [&](std::int64_t i) { ++visits[static_cast<std::size_t>(i)]; });
  for (const auto& count : visits)
    EXPECT_EQ(count, 1);
}

TEST(Parallel, BlocksCoverTheRangeWithoutOverlap) {
  for (const std::int64_t n : {0, 1, 9, 10, 11}) {
    std::vector<std::atomic<int>> visits(static_cast<std::size_t>(n));
    parallel_blocks(n, 5, [&](std::int64_t begin, std::int64_t end) {
      for (; begin < end; ++begin)
        ++visits[static_cast<std::size_t>(begin)];
    });
    for (const auto& count : visits)
      EXPECT_EQ(count, 1);
  }
}

TEST(Parallel, ConsumesInOrder) {
  std::vector<std::int64_t> order;
  parallel_in_order(
      100, [](std::int64_t i) { return i * i; },
      [&](std::int64_t i, std::int64_t square) {
        EXPECT_EQ(square, i * i);
        order.push_back(i);
      });
  ASSERT_EQ(order.size(), 100u);
  for (std::size_t i = 0; i < order.size(); ++i)
    EXPECT_EQ(order[i], static_cast<std::int64_t>(i));
}

TEST(Parallel, HoldsNoMoreResultsThanThreads) {
  std::atomic<int> held = 0, most = 0;
  struct Result {
    std::shared_ptr<void> life;
  };
  parallel_in_order(
      200,
      [&](std::int64_t) {
        const int now = ++held;
        for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
        }
        return Result{std::shared_ptr<void>(nullptr, [&](void*) { --held; })};
      },
      [](std::int64_t, const Result&) {});
  EXPECT_LE(most, thread_count());
  EXPECT_EQ(held, 0);
}

TEST(Parallel, RethrowsTheFirstException) {
  EXPECT_THROW(parallel_for(100,
                            [](std::int64_t i) {
                              if (i == 57) throw std::runtime_error("57");
                            }),
               std::runtime_error);
  EXPECT_THROW(parallel_in_order(
                   100, [](std::int64_t i) { return i; },
                   [](std::int64_t i, std::int64_t) {
                     if (i == 3) throw std::runtime_error("3");
                   }),
               std::runtime_error);
}

TEST(Parallel, NestedLoopsRun) {
  std::atomic<int> total = 0;
  parallel_for(10, [&](std::int64_t) { parallel_for(10, [&](std::int64_t) { ++total; }); });
  EXPECT_EQ(total, 100);
}

}  // namespace
}  // namespace micro
