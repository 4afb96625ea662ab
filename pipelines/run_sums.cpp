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
void persist(Archive& archive, ErrorSample& sample) {
  archive(sample.nodes, sample.squared, sample.squared_core_free, sample.significant, sample.significant_bad);
}
template <typename Archive>
void persist(Archive& archive, SpectrumOfScans& spectrum) {
  archive(spectrum.lambda_q, spectrum.mean, spectrum.errors, spectrum.unreached, spectrum.tolerance,
          spectrum.coherence_area, spectrum.windows, spectrum.pitch, spectrum.seconds);
}
template <typename Archive>
void persist(Archive& archive, Stage& stage) {
  archive(stage.outcome, stage.name, stage.reason);
}
template <typename Archive>
void persist(Archive& archive, SpectrumSums& sums) {
  archive(sums.spectrum, sums.dependence, sums.unfit, sums.refusals, sums.choice, sums.looked_at);
}
template <typename Archive>
void persist(Archive& archive, ScanRecord& scan) {
  archive(scan.source, scan.sha256, scan.format, scan.rows, scan.cols, scan.missing, scan.holes, scan.dx,
          scan.dy, scan.rejected, scan.filled, scan.Sq, scan.Sdq, scan.failure);
}

namespace {

// Sums have no state worth the name before they are read.
constexpr DiskGrid kNoGrid = {3, 1};

void persist_sums(ArchiveWriter& archive, const RunSums& sums) {
  archive(sums.scans, static_cast<std::uint32_t>(sums.means.size()), sums.directions.has_value(),
          sums.thumbnails, sums.spectrum);
  for (const NdfMean& mean : sums.means)
    archive(mean);
  if (sums.directions) archive(*sums.directions);
}

void persist_sums(ArchiveReader& archive, RunSums& sums) {
  constexpr std::uint32_t kMostMethods = 1000;
  std::uint32_t means = 0;
  bool directions = false;
  archive(sums.scans, means, directions, sums.thumbnails, sums.spectrum);
  if (means > kMostMethods) throw BrokenArchive();
  sums.means.assign(means, NdfMean({}, kNoGrid, {}));
  for (NdfMean& mean : sums.means)
    archive(mean);
  if (directions) archive(sums.directions.emplace(Kirchhoff{}, std::vector<Vec3>{}, kNoGrid));
}

/// Bytes of another version may mean something else.
std::string layout_of_this_version() {
  return "2 of microbrdf " + std::string(version());
}

std::vector<std::uint8_t> bytes_of(const NdfRequest& request, const Shard& shard, const RunSums& sums) {
  ArchiveWriter archive;
  archive(layout_of_this_version(), request, shard);
  persist_sums(archive, sums);
  return std::move(archive).bytes();
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
  archive(layout_of_this_version(), request);
  return std::move(archive).bytes();
}

std::vector<std::uint8_t> to_bytes(const ShardSums& shard) {
  return bytes_of(shard.request, shard.shard, shard.sums);
}

ShardSums shard_from(const std::vector<std::uint8_t>& bytes) {
  ArchiveReader archive(bytes);
  ShardSums shard;
  std::string layout;
  archive(layout);
  if (layout != layout_of_this_version()) throw BrokenArchive();
  archive(shard.request, shard.shard);
  persist_sums(archive, shard.sums);
  if (!archive.at_end()) throw BrokenArchive();
  return shard;
}

void write_checkpoint(const std::filesystem::path& path, const NdfRequest& request, const Shard& shard,
                      const RunSums& sums) {
  Hdf5Writer file(path);
  write_origin(file, origin_of("checkpoint"));
  const std::vector<std::uint8_t> bytes = bytes_of(request, shard, sums);
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

void JoinedShards::add(ShardSums shard) {
  if (!all_) {
    first_ = shard.shard;
    key_ = key_of(shard.request);
  }
  if (shard.shard.count != first_.count)
    throw InputError("shards of different runs: " + to_text(first_) + " and " + to_text(shard.shard));
  if (!records_.emplace(shard.shard.index, std::move(shard.sums.scans)).second)
    throw InputError("shard " + to_text(shard.shard) + " is there twice");
  if (key_of(shard.request) != key_)
    throw InputError("shards " + to_text(first_) + " and " + to_text(shard.shard) +
                     " were computed with different options");
  if (!all_) {
    all_ = std::move(shard);
    all_->shard = {};
    all_->sums.thumbnails.clear();
    return;
  }
  RunSums &sums = all_->sums, &more = shard.sums;
  for (std::size_t m = 0; m < sums.means.size(); ++m)
    sums.means[m].merge(more.means[m]);
  if (sums.directions) sums.directions->merge(*more.directions);
  if (sums.spectrum) merge(*sums.spectrum, *more.spectrum);
}

ShardSums JoinedShards::finish() && {
  if (!all_) throw InputError("there is no shard to join");
  for (int index = 1; index <= first_.count; ++index)
    if (!records_.contains(index))
      throw InputError("shard " + to_text(Shard{index, first_.count}) + " is missing");
  std::vector<ScanRecord>& scans = all_->sums.scans;
  scans.clear();
  std::set<std::string> sources;
  for (std::size_t row = 0; row < records_.begin()->second.size(); ++row)
    for (auto& [index, of_shard] : records_) {
      if (row >= of_shard.size()) continue;
      if (!sources.insert(of_shard[row].source).second)
        throw InputError("two shards hold the scan " + of_shard[row].source +
                         ": the directory changed between them");
      scans.push_back(std::move(of_shard[row]));
    }
  return std::move(*all_);
}

}  // namespace micro
