#include "pipelines/scan_listing.h"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <set>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/bytes.h"
#include "io/microbrdf_hdf5.h"
#include "io/scan.h"

namespace micro {
namespace {

namespace fs = std::filesystem;

bool is_same(const fs::path& a, const std::optional<fs::path>& b) {
  std::error_code ignored;
  return b && fs::equivalent(a, *b, ignored);
}

/// Does one of our HDF5 files end before its superblock says so? [HDF5 file format III, §II.A: the version
/// stands at byte 8, the address of the end at byte 40 of version 0, 28 of versions 2 and 3.] HDF5 does not
/// open such a file.
bool is_cut(const fs::path& path) {
  constexpr std::size_t kVersion = 8, kHead = 48;
  const FileBytes head(path, kHead);
  if (head.size() < kHead) return true;
  const std::size_t end = std::to_integer<int>(head.bytes()[kVersion]) == 0 ? 40 : 28;
  return head.file_size() < load<std::uint64_t>(head.data() + end, std::endian::little);
}

/// Why a file found in a directory is not taken; nothing if it is.
std::optional<std::string> reason_to_skip(const fs::path& path) {
  if (is_temporary(path)) return "an unfinished output of a run that was stopped";
  const ScanFormat* format = recognise_scan(path);
  if (!format) return "no scan by its content";
  if (format->listed == ScanFormat::Listed::Never) return "a " + std::string(format->description);
  if (format->listed == ScanFormat::Listed::WhenNamed)
    return std::string(format->name) + " is read only when its file is named";
  if (format->name == kMicrobrdfHdf5.name && is_cut(path)) return "a height file of microbrdf that was cut";
  return std::nullopt;
}

/// What a directory entry is that is neither a file nor a folder to look into.
std::string kind_of(const fs::directory_entry& entry) {
  std::error_code ignored;
  if (!entry.is_symlink(ignored)) return "neither a file nor a folder";
  return entry.is_directory(ignored) ? "a link to a folder" : "a link that leads to no file";
}

/// `prefix` goes before the names of what is found, which are relative to the directory.
void list_directory(const fs::path& directory, const fs::path& prefix,
                    const std::optional<fs::path>& leave_out, ScanListing& listing) {
  std::vector<fs::path> files;
  std::error_code error;
  fs::recursive_directory_iterator entry(directory, fs::directory_options::none, error);
  if (error) throw FileError(directory, "cannot be read: " + error.message());
  const auto source = [&](const fs::path& path) {
    return (prefix / path.lexically_relative(directory)).generic_string();
  };
  for (; entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    if (error) throw FileError(directory, "cannot be read: " + error.message());
    const fs::path& path = entry->path();
    std::error_code ignored;
    if (entry->is_directory(ignored) && !entry->is_symlink(ignored)) {
      if (is_same(path, leave_out)) {
        listing.skipped.push_back({source(path), "it is the output"});
        entry.disable_recursion_pending();
      } else if (::access(path.c_str(), R_OK | X_OK) != 0) {
        listing.skipped.push_back({source(path), "the folder cannot be read"});
        entry.disable_recursion_pending();
      }
    } else if (entry->is_regular_file(ignored)) {
      files.push_back(path);
    } else {
      listing.skipped.push_back({source(path), kind_of(*entry)});
    }
  }
  std::sort(files.begin(), files.end(),
            [&](const fs::path& a, const fs::path& b) { return source(a) < source(b); });
  for (const fs::path& path : files) {
    if (is_same(path, leave_out)) {
      listing.skipped.push_back({source(path), "it is the output"});
      continue;
    }
    std::optional<std::string> reason;
    try {
      reason = reason_to_skip(path);
    } catch (const FileError&) {
      // A file that cannot even be opened may be a scan: it fails when it is read, by name.
    }
    if (reason)
      listing.skipped.push_back({source(path), *reason});
    else
      listing.scans.push_back({path, source(path)});
  }
}

}  // namespace

ScanListing list_scans(const std::vector<fs::path>& paths, const std::optional<fs::path>& leave_out) {
  ScanListing listing;
  for (const fs::path& path : paths) {
    std::error_code error;
    if (fs::is_directory(path, error))
      list_directory(path, paths.size() > 1 ? path : fs::path(), leave_out, listing);
    else
      listing.scans.push_back({path, path.generic_string()});
  }
  // A file that is named twice is one scan.
  std::set<fs::path> seen;
  std::erase_if(listing.scans, [&](const ListedScan& scan) {
    std::error_code ignored;
    const bool again = !seen.insert(fs::weakly_canonical(scan.path, ignored)).second;
    if (again) listing.skipped.push_back({scan.source, "it is listed already"});
    return again;
  });
  return listing;
}

}  // namespace micro
