#include <gtest/gtest.h>
#include <sys/time.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/error.h"
#include "io/bytes.h"
#include "io/child_process.h"
#include "io/scan.h"
#include "io/small_scans_of_every_format_test.h"
#include "io/small_scans_test.h"
#include "testing/run_program.h"
#include "testing/sanitizers.h"
#include "testing/temporary_folder.h"

// Any bytes are a scan or a FileError, nothing else.
namespace micro {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

/// Reads whatever is there with one format: a scan or a refusal that names the file are both fine.
void read_or_refuse(const ScanFormat& format, const fs::path& path) {
  const FileBytes head(path, kHeadBytes);
  if (!format.recognise({.path = path, .size = head.file_size(), .bytes = head.bytes()})) return;
  try {
    const HeightField surface = format.read(path, {.pitch_x = 0.25, .pitch_y = {}});
    EXPECT_GT(surface.z.size(), 0);
    EXPECT_FALSE(surface.z.isInf().any());
    EXPECT_TRUE(surface.dx > 0 && surface.dy > 0);
  } catch (const FileError& error) {
    EXPECT_EQ(error.file(), path);
    EXPECT_EQ(error.fact().find('\n'), std::string::npos) << error.fact();
  }
}

/// The same through read_scan, which knows the formats and has the child process.
void read_scan_or_refuse(const fs::path& path) {
  try {
    EXPECT_GT(read_scan(path, {.pitch_x = 0.25, .pitch_y = {}}).surface.z.size(), 0);
  } catch (const FileError& error) {
    EXPECT_EQ(error.file(), path);
  }
}

const ScanFormat& format_named(const std::string& name) {
  return *std::find_if(scan_formats().begin(), scan_formats().end(),
                       [&](const ScanFormat& format) { return format.name == name; });
}

std::size_t below(std::mt19937& random, std::size_t limit) {
  return random() % limit;
}

/// One to four changes: bytes, 32-bit numbers of the kind that headers lie with, digits, cuts, repetitions.
Bytes mutated(Bytes bytes, std::mt19937& random) {
  constexpr std::array<std::uint32_t, 8> lies = {0,          1,          0x7FFFFFFF, 0x80000000,
                                                 0xFFFFFFFF, 0x7FC00000, 0x7F800000, 0xFF7FFFFF};
  for (std::size_t changes = 1 + below(random, 4); changes > 0 && !bytes.empty(); --changes) {
    const std::size_t at = below(random, bytes.size());
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const std::size_t length = std::min(bytes.size() - at, 1 + below(random, 16));
    switch (below(random, 6)) {
      case 0:
      case 1:
        *place = static_cast<std::byte>(random());
        break;
      case 2:
        if (bytes.size() - at >= 4) put(bytes, at, lies[below(random, lies.size())], below(random, 2) == 0);
        break;
      case 3:
        *place = static_cast<std::byte>("0123456789.-+eE#* \n"[below(random, 19)]);
        break;
      case 4:
        bytes.resize(at);
        break;
      default: {
        const Bytes again(place, place + static_cast<std::ptrdiff_t>(length));
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(below(random, bytes.size() + 1)),
                     again.begin(), again.end());
      }
    }
  }
  return bytes;
}

constexpr int kMutations = 1000;

/// Mutation k of a format, the same on every machine.
Bytes mutation(const std::vector<Bytes>& originals, int k) {
  std::mt19937 random(static_cast<std::uint32_t>(k));
  return mutated(originals[static_cast<std::size_t>(k) % originals.size()], random);
}

class HostileFiles : public ::testing::TestWithParam<std::string> {
 protected:
  /// The mutation that a child process died of, or kMutations, and what of.
  struct Death {
    int mutation;
    std::string fact;
  };
  /// Reads the mutations from `first` on in a child process, which tells in a file of its own where it is.
  Death read_in_child(const std::vector<Bytes>& originals, int first) const {
    const auto progress = folder.path() / "progress";
    try {
      ChildOutput told =
          run_in_child(path, {.processor_seconds = 60, .seconds = 300}, [&](ChildOutput& output) {
            for (int k = first; k < kMutations; ++k) {
              write_text(progress, std::to_string(k));
              write_bytes(path, mutation(originals, k));
              ::setitimer(ITIMER_VIRTUAL, &kTime, nullptr);  // a library may go in circles
              read_or_refuse(format, path);
            }
            output.write_value(::testing::Test::HasFailure());
          });
      EXPECT_FALSE(told.read_value<bool>()) << "something was read that is neither a scan nor refused";
      return {kMutations, ""};
    } catch (const FileError& error) {
      const auto bytes = read_bytes(progress);
      return {std::stoi(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())),
              error.fact()};
    }
  }
  static constexpr itimerval kTime = {.it_interval = {}, .it_value = {.tv_sec = 0, .tv_usec = 300000}};
  TemporaryFolder folder;
  fs::path path = folder.path() / "scan";
  const ScanFormat& format = format_named(GetParam());
};

TEST_P(HostileFiles, AThousandMutationsAreReadOrRefused) {
  const auto originals = small_scans_of_every_format(folder.path())[GetParam()];
  ASSERT_FALSE(originals.empty());
  if (format.container.empty()) {
    for (int k = 0; k < kMutations; ++k) {
      SCOPED_TRACE(k);
      write_bytes(path, mutation(originals, k));
      read_or_refuse(format, path);
    }
    return;
  }
  // A library may die of a file; then the program tells so, and goes on. (So it does when one goes in
  // circles, after seconds: ChildProcess.ItsTimeIsLimited.)
  for (int k = 0; k < kMutations; ++k) {
    const Death death = read_in_child(originals, k);
    k = death.mutation;
    if (k == kMutations) break;
    if (death.fact.find("signal " + std::to_string(SIGVTALRM)) != std::string::npos) continue;
    write_bytes(path, mutation(originals, k));
    EXPECT_THROW(read_scan(path, {.pitch_x = 0.25, .pitch_y = {}}), FileError) << k;
  }
  for (int k = 0; k < kMutations; k += kMutations / 10) {
    SCOPED_TRACE(k);
    write_bytes(path, mutation(originals, k));
    read_scan_or_refuse(path);
  }
}

/// What fuzzing found (docs/fuzzing.md), as far as it was mended here.
TEST_P(HostileFiles, WhatWasFoundIsReadOrRefused) {
  const fs::path found = fs::path(MICRO_SOURCE_DIR) / "fuzz" / "findings" / GetParam();
  if (!fs::exists(found)) return;
  for (const auto& file : fs::directory_iterator(found)) {
    SCOPED_TRACE(file.path());
    read_scan_or_refuse(file.path());
    if (format.container.empty()) read_or_refuse(format, file.path());
  }
}

/// The real program under the limits that it promises: 2 GiB of address space and 20 s, which here are for
/// all of a batch of files together. It ends by itself, with no signal.
TEST_P(HostileFiles, TheProgramSurvivesThem) {
  if (testing::kSanitized) GTEST_SKIP() << "sanitizers reserve more address space";
  constexpr int kBatch = 10;
  const auto originals = small_scans_of_every_format(folder.path())[GetParam()];
  for (int first = 0; first < MICRO_MUTATIONS_OF_PROGRAM; first += kBatch) {
    std::string files;
    for (int k = first; k < first + kBatch; ++k) {
      const fs::path file = folder.path() / std::to_string(k);
      write_bytes(file, mutation(originals, kMutations + k));  // others than those above
      files += " '" + file.string() + "'";
    }
    const auto outcome =
        testing::run_program("ulimit -v 2097152; exec timeout -s KILL 20 " +
                             testing::microbrdf("info --json --pitch 0.25" + files) + " 2>&1");
    EXPECT_TRUE(outcome.code >= 0 && outcome.code <= 3) << outcome.code << "\n"
                                                        << files << "\n"
                                                        << outcome.out;
    EXPECT_NE(outcome.out.find("\"scans\""), std::string::npos) << outcome.out;
  }
}

/// Every format that can be read.
std::vector<std::string> readable_formats() {
  std::vector<std::string> names;
  for (const ScanFormat& format : scan_formats())
    if (format.listed != ScanFormat::Listed::Never) names.emplace_back(format.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Formats, HostileFiles, ::testing::ValuesIn(readable_formats()),
                         [](const auto& format) {
                           std::string name = format.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

/// fuzz/formats.txt says how long each is fuzzed.
TEST(FuzzedFormats, AreAllThatCanBeRead) {
  std::ifstream list(fs::path(MICRO_SOURCE_DIR) / "fuzz" / "formats.txt");
  std::set<std::string> fuzzed;
  for (std::string line; std::getline(list, line);)
    if (!line.starts_with('#')) fuzzed.insert(line.substr(0, line.find(' ')));
  const auto names = readable_formats();
  EXPECT_EQ(fuzzed, std::set<std::string>(names.begin(), names.end()));
}

}  // namespace
}  // namespace micro
