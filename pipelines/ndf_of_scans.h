#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "distribution/disk_table.h"
#include "distribution/signature.h"
#include "io/png.h"
#include "pipelines/kirchhoff_directions.h"
#include "pipelines/kirchhoff_spectrum.h"
#include "pipelines/ndf_fits.h"
#include "pipelines/ndf_mean.h"
#include "pipelines/plan.h"
#include "pipelines/prepare_scan.h"
#include "pipelines/scan_listing.h"
#include "pipelines/scan_record.h"

namespace micro {

/// An instrument signature and what to call the tables that it blurred.
struct NamedSignature {
  std::string name;  ///< e.g. "1.5deg"
  Signature signature;
};

/// How far out a table goes: all that the data can tell (for D_K that ends at the first false order, sinθ =
/// λ_q/(2·pitch)), what holds the energy, or a half width in m_xy.
struct WholeDisk {};
struct HoldsEnergy {};
using Extent = std::variant<WholeDisk, HoldsEnergy, double>;

/// Everything that decides the outcome of a run; what is absent is neither computed nor stored.
struct NdfRequest {
  std::vector<NdfMethod> methods;
  std::optional<DirectionsRequest> directions;  ///< D_K at chosen half vectors, without a table
  std::optional<SpectrumRequest> spectrum;      ///< D_K at many wavelengths
  int size = 1025;                              ///< nodes along a side of the disk table
  Extent extent = WholeDisk{};
  Preparation prepare;
  std::optional<NamedSignature> signature;
  enum class Pitches { MustAgree, MayDiffer } pitches = Pitches::MustAgree;
  /// A scan to which a method does not apply: the method goes without it, or the scan fails.
  enum class Unfit { LeaveOut, Fail } unfit = Unfit::LeaveOut;
  enum class Statistics { LeaveOut, Compute } statistics = Statistics::Compute;
  int thumbnails = 0;  ///< pictures of the first so many scans
};

/// Every `count`-th scan of the listing, beginning with the `index`-th, 1 ≤ index ≤ count.
struct Shard {
  int index = 1, count = 1;
  bool operator==(const Shard&) const = default;
};

/// "2/4".
std::string to_text(const Shard& shard);

struct ShardSums;

struct NdfResult {
  std::vector<ScanRecord> scans;  ///< in the order of the listing
  std::vector<NdfOfScans> ndfs;
  std::optional<NdfFits> fits;  ///< of every NDF; ndf_of_scans leaves them out
  std::optional<DirectionsOfScans> directions;
  std::optional<SpectrumOfScans> spectrum;
  std::vector<Picture> thumbnails;
  Plan plan;
  std::int64_t resumed = 0;          ///< scans that an earlier run's checkpoint already held
  std::shared_ptr<ShardSums> shard;  ///< what merge needs, of one shard of several

  /// Whether there is no normal distribution in it.
  bool empty() const { return ndfs.empty() && !directions && !spectrum; }
};

/// Told after each scan.
struct Progress {
  std::int64_t done, total;
  const std::string& source;
};

/// How a run is carried out; nothing of it changes the result.
struct Course {
  Shard shard = {};                       ///< of several that are merged later
  std::filesystem::path checkpoint = {};  ///< file to keep unfinished work in; empty: none
  double seconds_between = 10;            ///< checkpoints; a slow disk's come more rarely
  std::function<bool()> interrupted = [] { return false; };
};

/// A run that was asked to stop: what it did is in its checkpoint.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The main recipe [Dong15 §4, §5]: reads, levels and measures each scan, estimates its normal distributions,
/// and averages them weighted by projected area. A scan that fails is recorded and the others go on. The
/// result is the same for any number of threads. Throws MixedPitches, naming the groups, if the scans'
/// pitches differ by more than 1 % and may not: nothing is computed once the second pitch is seen.
///
/// With a checkpoint the sums are written aside now and then, and read back if they are of the same request
/// and of files that have not changed: the result is that of an undisturbed run. The caller removes it when
/// the result is safe. Throws Interrupted when it is asked to stop.
NdfResult ndf_of_scans(const ScanListing& listing, const NdfRequest& request,
                       const std::function<void(const Progress&)>& report, const Course& course = {});

/// What one run over all scans would have given, from the joined sums of its shards (run_sums.h).
NdfResult ndf_of_shards(ShardSums joined);

}  // namespace micro
