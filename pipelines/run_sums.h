#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipelines/ndf_of_scans.h"

namespace micro {

/// All that a run has gathered from the scans that it has looked at: enough to go on from, and to be joined
/// with what other scans gave. Its size does not grow with the scans but for a record of each: 24 bytes a
/// node of each method's table, and of a spectrum 16 bytes a node of the disk and wavelength (from the second
/// scan on; 8 after the first): 41 wavelengths of 1025² are 0.54 GB.
struct RunSums {
  std::vector<ScanRecord> scans;  ///< in the order of the listing
  std::vector<NdfMean> means;     ///< one for each method
  std::optional<DirectionsMean> directions;
  std::optional<SpectrumSums> spectrum;  ///< once all scans have had their tables
  std::vector<Picture> thumbnails;
};

/// Everything that decides a run's numbers, as bytes: equal for equal requests to equal versions.
std::vector<std::uint8_t> key_of(const NdfRequest& request);

/// The request and the sums of one shard.
struct ShardSums {
  NdfRequest request;
  Shard shard;
  RunSums sums;
};

std::vector<std::uint8_t> to_bytes(const ShardSums& shard);
/// Throws BrokenArchive.
ShardSums shard_from(const std::vector<std::uint8_t>& bytes);

/// Writes the sums of an unfinished run, whole or not at all. Throws FileError.
void write_checkpoint(const std::filesystem::path& path, const NdfRequest& request, const Shard& shard,
                      const RunSums& sums);

/// The sums to go on from: those of a checkpoint that was written for this request and shard by this version,
/// of scans that stand first in the listing and have not changed since (SHA-256). Nothing if there is none.
std::optional<RunSums> read_checkpoint(const std::filesystem::path& path, const NdfRequest& request,
                                       const Shard& shard, const ScanListing& listing);

/// The scans of one shard: every `count`-th of the listing, beginning with the `index`-th.
ScanListing scans_of(const Shard& shard, const ScanListing& listing);

/// The sums of one run's shards, added up one by one: no more than the sum and one shard are held at once.
class JoinedShards {
 public:
  /// In any order; another order gives the same to rounding. Throws InputError, with a sentence, if the shard
  /// is of another run or of other options than the first, or there already.
  void add(ShardSums shard);
  /// All of them. Throws InputError if there is none, if one is missing, or if two hold the same scan.
  ShardSums finish() &&;

 private:
  std::optional<ShardSums> all_;  // without records
  std::vector<std::uint8_t> key_;
  Shard first_;
  std::map<int, std::vector<ScanRecord>> records_;  // by the shard's index
};

}  // namespace micro
