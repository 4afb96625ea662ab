#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/archive.h"
#include "core/error.h"
#include "io/hdf5_reader.h"
#include "pipelines/fits_of_result.h"
#include "pipelines/output_lock.h"
#include "pipelines/result_file.h"
#include "pipelines/run_sums.h"
#include "tools/commands.h"
#include "tools/ndf_options.h"
#include "tools/scan_output.h"

namespace micro::tools {
namespace {

struct Options {
  CommonOptions common;
  std::vector<std::string> shards;
  std::string output;
};

/// What a shard's file says of itself.
struct ShardFile {
  std::filesystem::path path;
  std::int64_t index;
  bool fitted;
  nlohmann::json plan;
};

ShardFile look_at_shard(const std::filesystem::path& path) {
  const Hdf5Reader file(path);
  file.require_complete();
  if (!file.contains("/shard/state")) throw FileError(path, "is no shard: it was not made with --shard");
  try {
    return {path, file.integer_attribute("/shard", "index"), file.contains("/fit"),
            nlohmann::json::parse(file.read_text("/plan"))};
  } catch (const nlohmann::json::exception&) {
    throw FileError(path, "holds a plan that is no JSON");
  }
}

ShardSums read_shard(const std::filesystem::path& path) {
  try {
    return shard_from(Hdf5Reader(path).read<std::uint8_t>("/shard/state"));
  } catch (const BrokenArchive&) {
    throw FileError(path, "holds the sums of another version of microbrdf");
  }
}

/// Stages that the shards had beyond the sums: what was drawn or left out.
void add_other_stages(Plan& plan, const nlohmann::json& of_shard) {
  for (const auto& stage : of_shard) {
    const std::string name = stage.at("stage");
    if (std::none_of(plan.begin(), plan.end(), [&](const Stage& known) { return known.name == name; }))
      plan.push_back({stage.at("ran").get<bool>() ? Stage::Outcome::Ran : Stage::Outcome::LeftOut, name,
                      stage.at("reason")});
  }
}

int run(const Options& options, const CLI::App& app) {
  std::vector<ShardFile> files;
  for (const std::string& path : options.shards)
    files.push_back(look_at_shard(path));
  // Added in this order whatever the order on the command line: to the last bit the same sums.
  std::stable_sort(files.begin(), files.end(),
                   [](const ShardFile& a, const ShardFile& b) { return a.index < b.index; });
  const OutputLock lock = OutputLock::of_file(options.output);
  JoinedShards shards;
  bool fitted = false;
  nlohmann::json plan;
  for (ShardFile& file : files) {
    shards.add(read_shard(file.path));
    fitted = fitted || file.fitted;
    if (plan.size() < file.plan.size()) plan = std::move(file.plan);
  }
  NdfResult result = ndf_of_shards(std::move(shards).finish());
  if (fitted) {
    result.fits = fits_of(result);
    result.plan.push_back(stage_of(*result.fits));
  }
  add_other_stages(result.plan, plan);
  if (!result.empty()) write_result(options.output, result, command_line_of(app));
  return conclude(result, {}, options.common, options.output);
}

}  // namespace

Run add_merge(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("SHARD", options->shards, "Results of all shards of one run (--shard i/n)")->required();
  app.add_option("-o,--output", options->output, "HDF5 file to write")->required();
  add_common_options(app, options->common, "microbrdf merge out1/result.h5 out2/result.h5 -o result.h5");
  return [options, &app] { return run(*options, app); };
}

}  // namespace micro::tools
