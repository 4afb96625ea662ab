#include "io/scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <string>
#include <utility>

#include "core/error.h"
#include "io/bytes.h"
#include "io/child_process.h"
#include "io/digital_surf.h"
#include "io/exr_heights.h"
#include "io/gsf.h"
#include "io/keyence_vk4.h"
#include "io/microbrdf_hdf5.h"
#include "io/npy.h"
#include "io/sdf.h"
#include "io/sensofar_plu.h"
#include "io/text_matrix.h"
#include "io/wyko_opd.h"
#include "io/x3p.h"
#include "io/zygo_ascii.h"
#include "io/zygo_dat.h"
#include "io/zygo_datx.h"

namespace micro {
namespace {

/// A new format is a file beside these and a line here. Plain text has no signature, so it comes last.
constexpr std::array kFormats = {kZygoDat,       kZygoAsc,         kZygoXyz,    kDigitalSurf,
                                 kSdf,           kWykoOpd,         kKeyenceVk4, kGsf,
                                 kX3p,           kExrHeights,      kNpy,        kSensofarPlu,
                                 kMicrobrdfHdf5, kMicrobrdfResult, kZygoDatx,   kTextMatrix};

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

bool needs_child(std::span<const std::byte> head) {
  return std::any_of(kFormats.begin(), kFormats.end(), [&](const ScanFormat& format) {
    return !format.container.empty() && begins_with(head, format.container);
  });
}

const ScanFormat* recognise(const FileBytes& file) {
  const FileHead head{.path = file.path(), .size = file.file_size(), .bytes = file.bytes()};
  const auto found = std::find_if(kFormats.begin(), kFormats.end(),
                                  [&](const ScanFormat& format) { return format.recognise(head); });
  return found == kFormats.end() ? nullptr : &*found;
}

/// Formats as numbers, for a child to name them; nullptr is the number behind the last one.
std::size_t index_of(const ScanFormat* format) {
  return format ? static_cast<std::size_t>(format - kFormats.data()) : kFormats.size();
}
const ScanFormat* format_at(std::size_t index) {
  return index < kFormats.size() ? &kFormats[index] : nullptr;
}

/// Why a file that no format recognises is refused.
std::string nothing_known(const FileBytes& head) {
  if (head.file_size() == 0) return "is empty";
  const auto bytes = head.bytes();
  const bool text = std::none_of(bytes.begin(), bytes.end(), [](std::byte b) { return b < std::byte{'\t'}; });
  return std::string("is no scan in a known format") +
         (text ? "; as a text matrix it would hold nothing but numbers, with decimal points, and # comments"
               : "");
}

Scan read_here(const FileBytes& head, const ReadOptions& options) {
  const ScanFormat* format = recognise(head);
  if (!format) throw FileError(head.path(), nothing_known(head));
  try {
    return {.surface = format->read(head.path(), options), .path = head.path(), .format = format->name};
  } catch (const std::bad_alloc&) {
    throw FileError(head.path(), "needs more memory than there is");
  }
}

/// What a child says of the scan that it read; the heights follow.
struct ScanReport {
  std::size_t format;
  Eigen::Index rows, cols;
  double dx, dy, mean;
};

Scan read_in_child(const FileBytes& head, const ReadOptions& options) {
  const auto size = static_cast<double>(head.file_size());
  constexpr double slow_processor = 2e7, slow_disk = 1e7;  // bytes a second
  ChildOutput output = run_in_child(
      head.path(), {.processor_seconds = 8 + size / slow_processor, .seconds = 14 + size / slow_disk},
      [&](ChildOutput& out) {
        const Scan scan = read_here(head, options);
        out.write_value(ScanReport{.format = index_of(recognise(head)),
                                   .rows = scan.surface.rows(),
                                   .cols = scan.surface.cols(),
                                   .dx = scan.surface.dx,
                                   .dy = scan.surface.dy,
                                   .mean = scan.surface.mean});
        out.write(scan.surface.z.data(), static_cast<std::size_t>(scan.surface.z.size()) * sizeof(float));
      });
  // A child whose memory was overwritten may have written anything.
  const auto report = output.read_value<ScanReport>();
  const ScanFormat* format = format_at(report.format);
  std::size_t bytes = 0;
  const bool fits = report.rows > 0 && report.cols > 0 &&
                    !__builtin_mul_overflow(report.rows, report.cols, &bytes) &&
                    !__builtin_mul_overflow(bytes, sizeof(float), &bytes) && bytes == output.remaining();
  if (!format || !fits || !std::isfinite(report.mean))
    throw FileError(head.path(), "is broken: the library that reads its format lost its way");
  try {
    HeightField surface{
        .z = Grid<float>(report.rows, report.cols), .dx = report.dx, .dy = report.dy, .mean = report.mean};
    output.read(surface.z.data(), bytes);
    return {.surface = std::move(surface), .path = head.path(), .format = format->name};
  } catch (const std::bad_alloc&) {
    throw FileError(head.path(), "needs more memory than there is");
  }
}

StageWindow stage_here(const FileBytes& head) {
  const ScanFormat* format = recognise(head);
  if (!format) throw FileError(head.path(), "is no scan in a known format");
  const auto window = format->stage ? format->stage(head.path()) : std::nullopt;
  if (!window) throw FileError(head.path(), "does not say where the stage stood");
  for (const double value : {window->x, window->y, window->width, window->height})
    head.require(std::isfinite(value), "its stage position makes no sense");
  head.require(window->width > 0 && window->height > 0,
               "has no lateral scale to compare stage positions with");
  return *window;
}

}  // namespace

std::span<const ScanFormat> scan_formats() {
  return kFormats;
}

const ScanFormat* recognise_scan(const std::filesystem::path& path) {
  const FileBytes file(path, kHeadBytes);
  if (!needs_child(file.bytes())) return recognise(file);
  ChildOutput output = run_in_child(path, {.processor_seconds = 3, .seconds = 5},
                                    [&](ChildOutput& out) { out.write_value(index_of(recognise(file))); });
  return format_at(output.read_value<std::size_t>());
}

Scan read_scan(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes head(path, kHeadBytes);
  Scan scan = needs_child(head.bytes()) ? read_in_child(head, options) : read_here(head, options);
  check_pitch_agrees(path, scan.surface, options);
  return scan;
}

StageWindow stage_window(const std::filesystem::path& path) {
  const FileBytes head(path, kHeadBytes);
  if (!needs_child(head.bytes())) return stage_here(head);
  return run_in_child(path, {.processor_seconds = 3, .seconds = 5},
                      [&](ChildOutput& out) { out.write_value(stage_here(head)); })
      .read_value<StageWindow>();
}

}  // namespace micro
