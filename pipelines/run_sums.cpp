#include "pipelines/run_sums.h"

#include <algorithm>
#include <set>

#include "core/archive.h"
#include "core/error.h"
#include "io/hdf5_reader.h"
#include "io/hdf5_writer.h"
#include "io/microbrdf_hdf5.h"
#include "io/sha256.h"
#include "pipelines/origin.h"
#include "pipelines/version.h"

namespace micro {

// What each value is made of, in the order of its bytes.
template <typename Archive>
void persist(Archive& archive, ReadOptions& read) {
  archive(read.pitch_x, read.pitch_y);
}
template <typename Archive>
void persist(Archive& archive, Preparation& prepare) {
  archive(prepare.read, prepare.level, prepare.outlier_threshold, prepare.holes);
}
template <typename Archive>
void persist(Archive& archive, Filtered& filtered) {
  archive(filtered.sigma);
}
template <typename Archive>
void persist(Archive& archive, SubWindows& windows) {
  archive(windows.area);
}
template <typename Archive>
void persist(Archive& archive, GaussianTaper& taper) {
  archive(taper.area);
}
template <typename Archive>
void persist(Archive& archive, Kirchhoff& kirchhoff) {
  archive(kirchhoff.lambda_q, kirchhoff.tolerance, kirchhoff.coherence, kirchhoff.by);
}
template <typename Archive>
void persist(Archive& archive, NdfMethod& method) {
  archive(method.name, method.kind);
}
template <typename Archive>
void persist(Archive& archive, DirectionsRequest& request) {
  archive(request.directions, request.kirchhoff);
}
template <typename Archive>
void persist(Archive& archive, AsManyAsNeeded& range) {
  archive(range.shortest, range.longest);
}
template <typename Archive>
void persist(Archive& archive, SpectrumRequest& request) {
  archive(request.lambda_q, request.tolerance, request.coherence, request.source);
}
template <typename Archive>
void persist(Archive& archive, NamedSignature& signature) {
  archive(signature.name, signature.signature.angle, signature.signature.response);
}
template <typename Archive>
void persist(Archive& archive, NdfRequest& request) {
  archive(request.methods, request.directions, request.spectrum, request.size, request.extent,
          request.prepare, request.signature, request.pitches, request.unfit, request.statistics,
          request.thumbnails);
}
template <typename Archive>
void persist(Archive& archive, Shard& shard) {
  archive(shard.index, shard.count);
}
template <typename Archive>
void persist(Archive& archive, ScanRecord& scan) {
  archive(scan.source, scan.sha256, scan.format, scan.rows, scan.cols, scan.missing, scan.holes, scan.dx,
          scan.dy, scan.rejected, scan.filled, scan.Sq, scan.Sdq, scan.failure);
}

namespace {

// Sums have no state worth the name before they are read.
constexpr DiskGrid kNoGrid = {3, 1};

void persist_sums(ArchiveWriter& archive, RunSums& sums) {
  auto means = static_cast<std::uint32_t>(sums.means.size());
  bool directions = sums.directions.has_value();
  archive(sums.scans, means, directions, sums.thumbnails);
  for (NdfMean& mean : sums.means)
    archive(mean);
  if (directions) archive(*sums.directions);
}

void persist_sums(ArchiveReader& archive, RunSums& sums) {
  constexpr std::uint32_t kMostMethods = 1000;
  std::uint32_t means = 0;
  bool directions = false;
  archive(sums.scans, means, directions, sums.thumbnails);
  if (means > kMostMethods) throw BrokenArchive();
  sums.means.assign(means, NdfMean({}, kNoGrid, {}));
  for (NdfMean& mean : sums.means)
    archive(mean);
  if (directions) archive(sums.directions.emplace(Kirchhoff{}, std::vector<Vec3>{}, kNoGrid));
}

/// Bytes of another version may mean something else.
std::string layout_of_this_version() {
  return "1 of microbrdf " + std::string(version());
}

template <typename Archive>
void persist_shard(Archive& archive, ShardSums& shard) {
  std::string layout = layout_of_this_version();
  archive(layout);
  if (layout != layout_of_this_version()) throw BrokenArchive();
  archive(shard.request, shard.shard);
  persist_sums(archive, shard.sums);
}

/// Whether a file still has the hash that was noted; a file that could not be read then must still not be
/// readable.
bool is_unchanged(const ScanRecord& record, const ListedScan& scan) {
  if (record.source != scan.source) return false;
  try {
    return sha256_of_file(scan.path) == record.sha256;
  } catch (const FileError&) {
    return record.sha256.empty();
  }
}

}  // namespace

std::vector<std::uint8_t> key_of(const NdfRequest& request) {
  ArchiveWriter archive;
  NdfRequest copy = request;
  std::string layout = layout_of_this_version();
  archive(layout, copy);
  return archive.bytes();
}

std::vector<std::uint8_t> to_bytes(const ShardSums& shard) {
  ArchiveWriter archive;
  ShardSums copy = shard;
  persist_shard(archive, copy);
  return archive.bytes();
}

ShardSums shard_from(const std::vector<std::uint8_t>& bytes) {
  ArchiveReader archive(bytes);
  ShardSums shard;
  persist_shard(archive, shard);
  if (!archive.at_end()) throw BrokenArchive();
  return shard;
}

void write_checkpoint(const std::filesystem::path& path, const NdfRequest& request, const Shard& shard,
                      const RunSums& sums) {
  Hdf5Writer file(path);
  write_origin(file, origin_of("checkpoint"));
  const std::vector<std::uint8_t> bytes = to_bytes({request, shard, sums});
  file.write<std::uint8_t>("/state", bytes, {bytes.size()});
  file.finish();
}

std::optional<RunSums> read_checkpoint(const std::filesystem::path& path, const NdfRequest& request,
                                       const Shard& shard, const ScanListing& listing) {
  if (path.empty() || !std::filesystem::exists(path)) return std::nullopt;
  try {
    const Hdf5Reader file(path);
    file.require_complete();
    ShardSums found = shard_from(file.read<std::uint8_t>("/state"));
    if (key_of(found.request) != key_of(request) || found.shard != shard) return std::nullopt;
    const std::vector<ScanRecord>& scans = found.sums.scans;
    if (scans.size() > listing.scans.size()) return std::nullopt;
    for (std::size_t k = 0; k < scans.size(); ++k)
      if (!is_unchanged(scans[k], listing.scans[k])) return std::nullopt;
    return std::move(found.sums);
  } catch (const FileError&) {
    return std::nullopt;  // cut or of another program: the work is done again
  } catch (const BrokenArchive&) {
    return std::nullopt;
  }
}

ScanListing scans_of(const Shard& shard, const ScanListing& listing) {
  ScanListing own;
  own.skipped = listing.skipped;
  for (std::size_t k = static_cast<std::size_t>(shard.index - 1); k < listing.scans.size();
       k += static_cast<std::size_t>(shard.count))
    own.scans.push_back(listing.scans[k]);
  return own;
}

ShardSums join(std::vector<ShardSums> shards) {
  if (shards.empty()) throw InputError("there is no shard to join");
  std::sort(shards.begin(), shards.end(),
            [](const ShardSums& a, const ShardSums& b) { return a.shard.index < b.shard.index; });
  const int count = shards.front().shard.count;
  const std::vector<std::uint8_t> key = key_of(shards.front().request);
  for (std::size_t k = 0; k < shards.size(); ++k) {
    const Shard& shard = shards[k].shard;
    if (shard.count != count)
      throw InputError("shards of different runs: " + to_text(shards.front().shard) + " and " +
                       to_text(shard));
    if (k > 0 && shard.index == shards[k - 1].shard.index)
      throw InputError("shard " + to_text(shard) + " is there twice");
    if (key_of(shards[k].request) != key)
      throw InputError("shards " + to_text(shards.front().shard) + " and " + to_text(shard) +
                       " were computed with different options");
  }
  for (int index = 1; index <= count; ++index)
    if (std::none_of(shards.begin(), shards.end(),
                     [&](const ShardSums& shard) { return shard.shard.index == index; }))
      throw InputError("shard " + to_text(Shard{index, count}) + " is missing");

  ShardSums all = std::move(shards.front());
  std::vector<std::vector<ScanRecord>> records = {std::move(all.sums.scans)};
  for (std::size_t k = 1; k < shards.size(); ++k) {
    RunSums& more = shards[k].sums;
    for (std::size_t m = 0; m < all.sums.means.size(); ++m)
      all.sums.means[m].merge(more.means[m]);
    if (all.sums.directions) all.sums.directions->merge(*more.directions);
    records.push_back(std::move(more.scans));
  }
  all.shard = {};
  all.sums.scans.clear();
  all.sums.thumbnails.clear();
  std::set<std::string> sources;
  for (std::size_t row = 0; row < records.front().size(); ++row)
    for (const std::vector<ScanRecord>& of_shard : records)
      if (row < of_shard.size()) all.sums.scans.push_back(of_shard[row]);
  for (const ScanRecord& scan : all.sums.scans)
    if (!sources.insert(scan.source).second)
      throw InputError("two shards hold the scan " + scan.source + ": the directory changed between them");
  return all;
}

}  // namespace micro
