#include "pipelines/scan_record.h"

#include <iomanip>
#include <new>
#include <sstream>

#include "core/error.h"
#include "io/file_stamp.h"
#include "io/sha256.h"

namespace micro {
namespace {

std::string numbered(std::size_t k) {
  std::ostringstream text;
  text << std::setw(5) << std::setfill('0') << k;
  return text.str();
}

void write_scan(Hdf5Writer& file, const std::string& group, const ScanRecord& scan) {
  file.create_group(group);
  const auto set = [&](const char* name, const auto& value) { file.set_attribute(group, name, value); };
  set("source", std::string_view(scan.source));
  set("status", std::string_view(scan.failure ? "failed" : "done"));
  set("message", std::string_view(scan.failure.value_or("")));
  if (!scan.sha256.empty()) set("sha256", std::string_view(scan.sha256));
  if (scan.failure) return;
  set("scan_format", std::string_view(scan.format));
  set("rows", scan.rows);
  set("cols", scan.cols);
  set("dx_um", scan.dx);
  set("dy_um", scan.dy);
  set("missing", scan.missing);
  if (scan.rejected > 0) set("rejected", scan.rejected);
  if (scan.filled > 0) set("filled", scan.filled);
  if (scan.Sq) set("Sq_um", *scan.Sq);
  if (scan.Sdq) set("Sdq", *scan.Sdq);
}

}  // namespace

PreparedScan hash_and_prepare(const std::filesystem::path& path, const Preparation& preparation,
                              ScanRecord& record) {
  const FileStamp before = stamp_of(path);
  record.sha256 = sha256_of_file(path);
  const auto require_unchanged = [&] {
    if (stamp_of(path) == before) return;
    record.sha256.clear();  // so that a checkpoint does not take it for looked at
    throw FileError(path, "changed while it was read");
  };
  try {
    PreparedScan prepared = prepare_scan(path, preparation);
    require_unchanged();
    return prepared;
  } catch (const FileError&) {
    require_unchanged();  // which is why it could not be read
    throw;
  }
}

void describe(ScanRecord& record, const PreparedScan& prepared) {
  const HeightField& surface = prepared.surface;
  record.format = prepared.format;
  record.rows = surface.rows();
  record.cols = surface.cols();
  record.dx = surface.dx;
  record.dy = surface.dy;
  record.missing = prepared.missing;
  record.holes = missing_count(surface);
  record.rejected = prepared.rejected;
  record.filled = prepared.filled;
}

std::string reason_of_failure() {
  try {
    throw;
  } catch (const FileError& error) {
    return error.fact();
  } catch (const std::bad_alloc&) {
    return "not enough memory for this scan";
  } catch (const std::exception& error) {
    return error.what();
  }
}

void write_scans(Hdf5Writer& file, const std::vector<ScanRecord>& scans) {
  file.create_group("/scans");
  for (std::size_t k = 0; k < scans.size(); ++k)
    write_scan(file, "/scans/" + numbered(k), scans[k]);
}

}  // namespace micro
