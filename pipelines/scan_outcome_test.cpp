#include "pipelines/scan_outcome.h"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "io/sha256.h"
#include "io/zygo_dat.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

namespace fs = std::filesystem;

/// A file whose end grows all the time: its hash and its heights would be of two different files.
TEST(LookAt, AFileThatGrowsWhileItIsReadIsNoScan) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "scan.dat";
  write_zygo_dat(path, make_height_field(Grid<double>::Random(200, 200), 0.2, 0.2));
  const ListedScan scan = {path, "scan.dat"};
  EXPECT_FALSE(look_at(scan, {}, {}, Thumbnail::LeaveOut).record.failure);

  std::atomic<bool> enough = false;
  std::thread writer([&] {
    std::ofstream file(path, std::ios::app | std::ios::binary);
    while (!enough) {
      file << "more" << std::flush;
      std::this_thread::yield();
    }
  });
  // One look may fall between two of the writer's turns.
  constexpr int kMostLooks = 1000;
  ScanRecord record;
  for (int look = 0; look < kMostLooks && !record.failure; ++look)
    record = look_at(scan, {}, {}, Thumbnail::LeaveOut).record;
  enough = true;
  writer.join();
  EXPECT_EQ(record.failure, "changed while it was read");
  EXPECT_EQ(record.sha256, "") << "a resumed run would take it for looked at";

  record = look_at(scan, {}, {}, Thumbnail::LeaveOut).record;
  EXPECT_FALSE(record.failure);
  EXPECT_EQ(record.sha256, sha256_of_file(path));
}

}  // namespace
}  // namespace micro
