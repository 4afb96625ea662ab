#include "pipelines/run_sums.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <optional>
#include <string>
#include <thread>

#include "core/archive.h"
#include "core/error.h"
#include "height/gaussian_surface.h"
#include "height/make_holes.h"
#include "io/zygo_dat.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

namespace fs = std::filesystem;

/// Sums of the same numbers in another order [design: 1e-9 relative].
constexpr double kRounding = 1e-12;

/// Seven small scans, the third with holes, the fifth broken.
class RunSumsOfScans : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(scans());
    for (std::uint64_t k = 0; k < 7; ++k)
      write(k, make_holes(gaussian_surface({24, 20 + static_cast<Eigen::Index>(3 * k), 0.2, 0.2},
                                           {.rms = 0.2, .tau_x = 1.5, .tau_y = 1.5}, k),
                          {.fraction = k == 2 ? 0.05 : 0}, 7));
    fs::resize_file(scan(4), 1000);
  }
  fs::path scans() const { return folder_.path() / "scans"; }
  fs::path scan(std::uint64_t k) const { return scans() / ("scan" + std::to_string(k) + ".dat"); }
  fs::path checkpoint() const { return folder_.path() / "checkpoint.h5"; }
  void write(std::uint64_t k, const HeightField& surface) { write_zygo_dat(scan(k), surface); }

  static NdfRequest request() {
    NdfRequest request;
    request.methods = {
        {"naive", Naive{}}, {"filtered", Filtered{0.5}}, {"kirchhoff", Kirchhoff{.tolerance = 1e-2}}};
    request.directions = DirectionsRequest{3, Kirchhoff{}};
    request.spectrum = SpectrumRequest{std::vector<double>{0.5, 0.6}, 1e-2, WholePatch{}, {}};
    request.size = 33;
    request.thumbnails = 2;
    return request;
  }
  NdfResult run(const Course& course = {}, const NdfRequest& what = request()) const {
    return ndf_of_scans(
        list_scans({scans()}), what, [](const Progress&) {}, course);
  }
  /// Stops after so many scans; what it did is in the checkpoint.
  void stop_after(int scans) const {
    int seen = 0;
    EXPECT_THROW(run({.checkpoint = checkpoint(), .interrupted = [&] { return ++seen == scans; }}),
                 Interrupted);
    EXPECT_TRUE(fs::exists(checkpoint()));
  }
  ShardSums shard(int index, int count, const NdfRequest& what = request()) const {
    // As bytes: the way they go through files.
    return shard_from(to_bytes(*run({.shard = {index, count}}, what).shard));
  }

  TemporaryFolder folder_;
};

void expect_equal(const NdfResult& got, const NdfResult& want, double tolerance) {
  ASSERT_EQ(got.scans.size(), want.scans.size());
  for (std::size_t k = 0; k < got.scans.size(); ++k) {
    EXPECT_EQ(got.scans[k].source, want.scans[k].source);
    EXPECT_EQ(got.scans[k].sha256, want.scans[k].sha256);
    EXPECT_EQ(got.scans[k].Sq, want.scans[k].Sq);
    EXPECT_EQ(got.scans[k].failure, want.scans[k].failure);
  }
  const auto expect_close = [&](const Grid<double>& a, const Grid<double>& b) {
    ASSERT_EQ(a.size(), b.size());
    EXPECT_LE((a - b).abs().maxCoeff(), tolerance * b.maxCoeff());
  };
  ASSERT_EQ(got.ndfs.size(), want.ndfs.size());
  for (std::size_t m = 0; m < got.ndfs.size(); ++m) {
    const NdfOfScans &a = got.ndfs[m], &b = want.ndfs[m];
    EXPECT_EQ(a.method.name, b.method.name);
    EXPECT_EQ(a.estimator, b.estimator);
    EXPECT_EQ(a.scans, b.scans);
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_EQ(a.truncation_error, b.truncation_error);
    EXPECT_NEAR(a.area, b.area, tolerance * b.area);
    EXPECT_NEAR(a.rel_error, b.rel_error, kRounding);
    expect_close(a.density.density, b.density.density);
    // A variance is a difference of sums: half of its digits are left.
    const double digits = tolerance > 0 ? 1e-7 : 0;
    EXPECT_LE((*a.standard_error - *b.standard_error).abs().maxCoeff(),
              digits * b.standard_error->maxCoeff());
  }
  ASSERT_TRUE(got.spectrum && want.spectrum);
  const SpectrumOfScans &a = *got.spectrum, &b = *want.spectrum;
  ASSERT_EQ(a.lambda_q, b.lambda_q);
  EXPECT_EQ(a.mean.count(), b.mean.count());
  EXPECT_EQ(a.windows, b.windows);
  EXPECT_EQ(a.unreached, b.unreached);
  for (std::size_t k = 0; k < a.lambda_q.size(); ++k) {
    EXPECT_NEAR(a.rel_error(k), b.rel_error(k), kRounding);
    expect_close(a.mean.mean(k).density, b.mean.mean(k).density);
    // Deviations are summed in float.
    const Grid<double> error = *b.mean.standard_error(k);
    EXPECT_LE((*a.mean.standard_error(k) - error).abs().maxCoeff(),
              (tolerance > 0 ? 1e-5 : 0) * error.maxCoeff());
  }
  const auto of_spectrum = [](const NdfResult& result) {
    std::map<std::string, std::string> reasons;
    for (const Stage& stage : result.plan)
      if (stage.name == "kirchhoff spectrum" || stage.name == "dependence on wavelength")
        reasons[stage.name] = stage.reason;
    return reasons;
  };
  EXPECT_EQ(of_spectrum(got), of_spectrum(want));
  EXPECT_EQ(of_spectrum(got).size(), 2u);
  ASSERT_TRUE(got.directions && want.directions);
  for (std::size_t k = 0; k < want.directions->density.size(); ++k)
    EXPECT_NEAR(got.directions->density[k], want.directions->density[k],
                tolerance * want.directions->density[k]);
}

TEST_F(RunSumsOfScans, AStoppedRunGoesOnToTheSameResult) {
  const NdfResult undisturbed = run();
  ASSERT_EQ(undisturbed.ndfs.size(), 3u);
  for (int scans = 1; scans <= 7 + 6; ++scans) {  // the spectrum comes behind, without the broken one
    SCOPED_TRACE(scans);
    stop_after(scans);
    const NdfResult resumed = run({.checkpoint = checkpoint()});
    EXPECT_EQ(resumed.resumed, std::min(scans, 7));
    expect_equal(resumed, undisturbed, 0);
    EXPECT_EQ(resumed.thumbnails.size(), undisturbed.thumbnails.size());
    fs::remove(checkpoint());
  }
}

TEST_F(RunSumsOfScans, StoppedTwiceIsStoppedOnce) {
  const NdfResult undisturbed = run();
  stop_after(2);
  stop_after(3);
  const NdfResult resumed = run({.checkpoint = checkpoint()});
  EXPECT_EQ(resumed.resumed, 5);
  expect_equal(resumed, undisturbed, 0);
}

TEST_F(RunSumsOfScans, ChangesAreNoticed) {
  stop_after(4);
  NdfRequest other = request();
  other.prepare.level = Level::Quadratic;
  EXPECT_EQ(run({.checkpoint = checkpoint()}, other).resumed, 0);
  other = request();
  std::get<Filtered>(other.methods[1].kind).sigma = 0.6;
  EXPECT_EQ(run({.checkpoint = checkpoint()}, other).resumed, 0);
  EXPECT_EQ(run({.shard = {1, 2}, .checkpoint = checkpoint()}).resumed, 0);
  EXPECT_EQ(run({.checkpoint = checkpoint()}).resumed, 4) << "the checkpoint itself is sound";
  // A scan that the checkpoint holds: the same size, other heights.
  write(1, gaussian_surface({24, 23, 0.2, 0.2}, {.rms = 0.2, .tau_x = 1.5, .tau_y = 1.5}, 99));
  const NdfResult changed = run({.checkpoint = checkpoint()});
  EXPECT_EQ(changed.resumed, 0);
  expect_equal(changed, run(), 0);
  // One that it does not hold yet may change.
  stop_after(2);
  write(6, gaussian_surface({24, 23, 0.2, 0.2}, {.rms = 0.2, .tau_x = 1.5, .tau_y = 1.5}, 98));
  const NdfResult later = run({.checkpoint = checkpoint()});
  EXPECT_EQ(later.resumed, 2);
  expect_equal(later, run(), 0);
  fs::remove(scan(0));
  EXPECT_EQ(run({.checkpoint = checkpoint()}).resumed, 0);
}

TEST_F(RunSumsOfScans, AScanThatChangesBeforeTheSpectrumIsNamed) {
  const NdfResult before = run();
  for (const bool gone : {false, true}) {
    SetUp();
    const NdfResult result = ndf_of_scans(list_scans({scans()}), request(), [&](const Progress& progress) {
      if (progress.done != progress.total) return;  // all seven are looked at, the spectrum comes
      if (gone)
        fs::remove(scan(5));
      else
        write(5, gaussian_surface({24, 20, 0.2, 0.2}, {.rms = 0.2, .tau_x = 1.5, .tau_y = 1.5}, 99));
    });
    EXPECT_NE(result.scans[5].failure.value_or("").find("changed"), std::string::npos);
    ASSERT_TRUE(result.spectrum && before.spectrum);
    EXPECT_EQ(result.spectrum->mean.count(), before.spectrum->mean.count() - 1);
    EXPECT_TRUE((result.ndfs[0].density.density == before.ndfs[0].density.density).all());
  }
}

/// Writes what stands there to a file, over and over: it always has the same hash, and is always being
/// changed.
class WritesTheSame {
 public:
  explicit WritesTheSame(const fs::path& path)
      : thread_([this, path] {
          auto time = fs::last_write_time(path);
          while (!enough_) {
            fs::last_write_time(path, time += std::chrono::seconds(1));
            std::this_thread::yield();
          }
        }) {}
  ~WritesTheSame() {
    enough_ = true;
    thread_.join();
  }
  WritesTheSame(const WritesTheSame&) = delete;
  WritesTheSame& operator=(const WritesTheSame&) = delete;

 private:
  std::atomic<bool> enough_ = false;
  std::thread thread_;
};

TEST_F(RunSumsOfScans, AScanThatChangesBetweenTheSpectrumsTwoReadingsIsNamed) {
  constexpr int kMostRuns = 1000;  // one may fall between two of the writer's turns
  write(5, gaussian_surface({200, 200, 0.2, 0.2}, {.rms = 0.2, .tau_x = 1.5, .tau_y = 1.5}, 5));
  NdfRequest what = request();
  what.methods.resize(1);
  what.directions.reset();
  what.spectrum->lambda_q = std::vector<double>{0.5};
  std::string failure;
  for (int run = 0; run < kMostRuns && failure.empty(); ++run) {
    std::optional<WritesTheSame> writer;
    const NdfResult result = ndf_of_scans(list_scans({scan(5)}), what, [&](const Progress& progress) {
      if (progress.done == progress.total && !writer) writer.emplace(scan(5));  // the spectrum comes
    });
    failure = result.scans[0].failure.value_or("");
  }
  EXPECT_NE(failure.find("changed between two readings"), std::string::npos) << failure;
}

TEST_F(RunSumsOfScans, ACheckpointThatWasCutIsWorthNothing) {
  stop_after(3);
  const auto size = fs::file_size(checkpoint());
  for (const std::uintmax_t length :
       {size - 1, size - 5000, size / 2, std::uintmax_t{100}, std::uintmax_t{0}}) {
    fs::resize_file(checkpoint(), length);
    EXPECT_EQ(run({.checkpoint = checkpoint()}).resumed, 0) << length;
  }
}

TEST_F(RunSumsOfScans, ShardsGiveWhatOneRunGives) {
  const NdfResult whole = run();
  for (const int count : {2, 3, 9}) {  // 9: two shards hold no scan
    SCOPED_TRACE(count);
    JoinedShards shards;
    for (int index = count; index >= 1; --index)
      shards.add(shard(index, count));
    expect_equal(ndf_of_shards(std::move(shards).finish()), whole, kRounding);
  }
}

TEST_F(RunSumsOfScans, ShardsAgreeOnTheWavelengthsThatAreChosen) {
  NdfRequest chooses;
  chooses.spectrum = SpectrumRequest{AsManyAsNeeded{}, 1e-2, WholePatch{}, {}};
  chooses.size = 33;
  chooses.statistics = NdfRequest::Statistics::LeaveOut;
  const NdfResult whole = run({}, chooses);
  JoinedShards shards;
  for (const int index : {1, 2})
    shards.add(shard(index, 2, chooses));
  const NdfResult joined = ndf_of_shards(std::move(shards).finish());
  ASSERT_TRUE(whole.spectrum && joined.spectrum);
  EXPECT_EQ(joined.spectrum->lambda_q, whole.spectrum->lambda_q);
  EXPECT_LE((joined.spectrum->mean.mean(0).density - whole.spectrum->mean.mean(0).density).abs().maxCoeff(),
            kRounding * whole.spectrum->mean.mean(0).density.maxCoeff());
}

TEST_F(RunSumsOfScans, ShardsThatDoNotBelongTogetherAreRefused) {
  const ShardSums one = shard(1, 2), two = shard(2, 2), third = shard(1, 3);
  NdfRequest other = request();
  other.prepare.level = Level::None;
  const ShardSums unlevelled = shard(2, 2, other);
  const auto sentence = [](const std::vector<ShardSums>& shards) {
    try {
      JoinedShards joined;
      for (const ShardSums& each : shards)
        joined.add(each);
      std::move(joined).finish();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(sentence({one}), "shard 2/2 is missing");
  EXPECT_EQ(sentence({two, two}), "shard 2/2 is there twice");
  EXPECT_EQ(sentence({two, third}), "shards of different runs: 2/2 and 1/3");
  EXPECT_EQ(sentence({one, unlevelled}), "shards 1/2 and 2/2 were computed with different options");
  ShardSums again = one;
  again.shard.index = 2;
  EXPECT_EQ(sentence({one, again}), "two shards hold the scan scan0.dat: the directory changed between them");
  EXPECT_EQ(sentence({}), "there is no shard to join");
  EXPECT_EQ(sentence({two, one}), "");
}

}  // namespace
}  // namespace micro
