#include "io/scan.h"

#include <array>
#include <cmath>
#include <string>

#include "core/error.h"
#include "io/bytes.h"
#include "io/digital_surf.h"
#include "io/microbrdf_hdf5.h"
#include "io/npy.h"
#include "io/sdf.h"
#include "io/sensofar_plu.h"
#include "io/text_matrix.h"
#include "io/wyko_opd.h"
#include "io/zygo_ascii.h"
#include "io/zygo_dat.h"
#include "io/zygo_datx.h"

namespace micro {
namespace {

/// A new format is a file beside these and a line here. Plain text has no signature, so it comes last.
constexpr std::array kFormats = {kZygoDat,       kZygoAsc,         kZygoXyz,     kDigitalSurf,
                                 kSdf,           kWykoOpd,         kSensofarPlu, kNpy,
                                 kMicrobrdfHdf5, kMicrobrdfResult, kZygoDatx,    kTextMatrix};

/// Whatever the user says about the pitch may fill a gap in a file; it may not contradict one.
void check_pitch_agrees(const std::filesystem::path& path, const HeightField& surface,
                        const ReadOptions& options) {
  if (!options.pitch_x) return;
  constexpr double rounding = 1e-6;  // of the 32-bit floats that most formats keep their scale in
  const double dx = *options.pitch_x, dy = options.pitch_y.value_or(dx);
  if (std::abs(surface.dx - dx) > rounding * dx || std::abs(surface.dy - dy) > rounding * dy)
    throw FileError(path, "says itself that its pitch is " + std::to_string(surface.dx) + " × " +
                              std::to_string(surface.dy) + " µm, which --pitch contradicts");
}

}  // namespace

std::span<const ScanFormat> scan_formats() {
  return kFormats;
}

const ScanFormat* recognise_scan(const std::filesystem::path& path) {
  const FileBytes file(path, kHeadBytes);
  const FileHead head{.path = path, .size = file.file_size(), .bytes = file.bytes()};
  for (const ScanFormat& format : kFormats)
    if (format.recognise(head)) return &format;
  return nullptr;
}

Scan read_scan(const std::filesystem::path& path, const ReadOptions& options) {
  const ScanFormat* format = recognise_scan(path);
  if (!format) throw FileError(path, "is no scan in a known format");
  Scan scan{.surface = format->read(path, options), .path = path, .format = format->name};
  check_pitch_agrees(path, scan.surface, options);
  return scan;
}

}  // namespace micro
