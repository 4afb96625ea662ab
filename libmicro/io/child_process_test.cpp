#include "io/child_process.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <ctime>
#include <memory>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "io/hdf5_reader.h"
#include "io/microbrdf_hdf5.h"
#include "testing/sanitizers.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

const std::filesystem::path kFile = "some/file";
constexpr ChildLimits kPlenty = {.processor_seconds = 60, .seconds = 60};

std::string fact_of(const ChildLimits& limits, const std::function<void(ChildOutput&)>& work) {
  try {
    run_in_child(kFile, limits, work);
  } catch (const FileError& error) {
    EXPECT_EQ(error.file(), kFile);
    return error.fact();
  }
  return "";
}

TEST(ChildProcess, LeavesWhatItWrote) {
  const std::vector<double> numbers = {1, 2.5, -3};
  ChildOutput output = run_in_child(kFile, kPlenty, [&](ChildOutput& out) {
    out.write_value(::getpid());
    out.write(numbers.data(), numbers.size() * sizeof(double));
  });
  EXPECT_NE(output.read_value<pid_t>(), ::getpid());
  EXPECT_EQ(output.remaining(), numbers.size() * sizeof(double));
  std::vector<double> back(3);
  output.read(back.data(), output.remaining());
  EXPECT_EQ(back, numbers);
  EXPECT_THROW(output.read_value<char>(), std::system_error);
}

TEST(ChildProcess, ItsRefusalsAreOurs) {
  EXPECT_EQ(fact_of(kPlenty,
                    [](ChildOutput& out) {
                      out.write_value(1);
                      throw FileError(kFile, "holds no heights");
                    }),
            "holds no heights");
  EXPECT_EQ(fact_of(kPlenty, [](ChildOutput&) { throw FileError("other", "is cut"); }), "other: is cut");
  EXPECT_EQ(fact_of(kPlenty, [](ChildOutput&) { throw std::runtime_error("odd"); }), "odd");
  EXPECT_NE(fact_of(kPlenty, [](ChildOutput&) { throw 1; }), "");
}

TEST(ChildProcess, ItsDeathIsOneSentence) {
  for (const int number : {SIGSEGV, SIGABRT, SIGBUS, SIGKILL})
    EXPECT_NE(fact_of(kPlenty, [=](ChildOutput&) { ::raise(number); }).find("crashed"), std::string::npos);
  EXPECT_NE(fact_of(kPlenty, [](ChildOutput&) { ::_exit(1); }).find("gave up"), std::string::npos);
}

TEST(ChildProcess, ItsTimeIsLimited) {
  EXPECT_NE(
      fact_of({.processor_seconds = 60, .seconds = 0.05}, [](ChildOutput&) { ::pause(); }).find("longer"),
      std::string::npos);
  EXPECT_NE(fact_of({.processor_seconds = 1, .seconds = 60},
                    [](ChildOutput&) {
                      while (std::clock() >= 0) {
                      }
                    })
                .find("longer"),
            std::string::npos);
}

TEST(ChildProcess, ItsMemoryIsLimited) {
  if (testing::kSanitized) GTEST_SKIP() << "sanitizers abort where memory cannot be had";
  constexpr std::size_t too_much = std::size_t{4} << 30;
  const auto take = [](ChildOutput& out) {
    const std::unique_ptr<char[]> bytes(new char[too_much]);
    out.write_value(bytes[too_much - 1]);
  };
  EXPECT_NE(fact_of(kPlenty, take).find("memory"), std::string::npos);
}

TEST(ChildProcess, IsBornWhileOtherThreadsUseHdf5) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.h5";
  write_microbrdf_hdf5(path, make_height_field(Grid<double>::Random(20, 30), 1, 1), {"0", "now", "test"});
  parallel_for(40, [&](std::int64_t k) {
    if (k % 2 == 0) {
      EXPECT_EQ(Hdf5Reader(path).read_grid<float>("/height/z").size(), 600);
    } else {
      ChildOutput output = run_in_child(path, kPlenty, [&](ChildOutput& out) {
        out.write_value(Hdf5Reader(path).read_grid<float>("/height/z").size());
      });
      EXPECT_EQ(output.read_value<Eigen::Index>(), 600);
    }
  });
}

}  // namespace
}  // namespace micro
