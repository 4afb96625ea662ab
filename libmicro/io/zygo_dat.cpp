#include "io/zygo_dat.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "io/atomic_file.h"
#include "io/bytes.h"
#include "io/zygo_scale.h"

namespace micro {
namespace {

/// Where the fields stand in the header, bytes.
enum Offset : std::size_t {
  kMagic = 0,            // u32, 0x881B036F + format − 1
  kFormat = 4,           // u16
  kHeaderSize = 6,       // u32
  kIntensityBytes = 60,  // u32
  kPhaseWidth = 68,      // u16
  kPhaseHeight = 70,     // u16
  kPhaseBytes = 72,      // u32
  kScaleFactor = 164,    // f32, S
  kWavelength = 168,     // f32, W in m
  kObliquity = 176,      // f32, O
  kLateralRes = 184,     // f32, m, 0 = unknown
  kPhaseRes = 218,       // i16
  kSign = 232,           // i16
  kCameraWidth = 234,    // i16
  kCameraHeight = 236,   // i16
  kWavelength1 = 386,    // f32
};
constexpr std::uint32_t kMagic1 = 0x881B036F;
constexpr std::size_t kHeaderBytes = 834;  // of formats 1 and 2; format 3 has 4096

template <typename T>
T field(const std::byte* header, Offset offset) {
  return load<T>(header + offset, std::endian::big);
}

template <typename T>
void set_field(std::vector<std::byte>& header, Offset offset, T value) {
  store(header.data() + offset, value, std::endian::big);
}

}  // namespace

bool is_zygo_dat(const FileHead& head) {
  if (head.bytes.size() < sizeof(std::uint32_t)) return false;
  const auto magic = field<std::uint32_t>(head.bytes.data(), kMagic);
  return magic >= kMagic1 && magic <= kMagic1 + 2;
}

HeightField read_zygo_dat(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file(path);
  file.require(file.size() >= kHeaderBytes, "is shorter than a MetroPro header");
  const std::byte* header = file.data();
  const std::uint64_t header_bytes = field<std::uint32_t>(header, kHeaderSize);
  const std::uint64_t intensity_bytes = field<std::uint32_t>(header, kIntensityBytes);
  const std::uint64_t phase_bytes = field<std::uint32_t>(header, kPhaseBytes);
  const std::uint64_t cols = field<std::uint16_t>(header, kPhaseWidth);
  const std::uint64_t rows = field<std::uint16_t>(header, kPhaseHeight);
  file.require(header_bytes >= kHeaderBytes, "its header says that it is shorter than a MetroPro header");
  file.require(phase_bytes == 4 * rows * cols, "its number of height bytes contradicts its rows and columns");
  file.require(header_bytes + intensity_bytes + phase_bytes <= file.size(),
               "is cut: its header promises more bytes than it has");

  const double step = zygo_step(path, {.interferometric = field<float>(header, kScaleFactor),
                                       .wavelength = field<float>(header, kWavelength),
                                       .obliquity = field<float>(header, kObliquity),
                                       .phase_res = field<std::int16_t>(header, kPhaseRes),
                                       .sign = field<std::int16_t>(header, kSign)});
  const double lateral = 1e6 * static_cast<double>(field<float>(header, kLateralRes));
  const Pitch pitch = file_pitch(path, {lateral, lateral}, options);
  const std::byte* phase = file.data() + header_bytes + intensity_bytes;
  return read_height_field(path, rows, cols, pitch, [=](Eigen::Index k) {
    const auto raw = load<std::int32_t>(phase + 4 * k, std::endian::big);
    return raw < kZygoMissing ? raw * step : std::numeric_limits<double>::quiet_NaN();
  });
}

void write_zygo_dat(const std::filesystem::path& path, const HeightField& surface) {
  constexpr Eigen::Index most = 65535;
  if (surface.rows() < 1 || surface.cols() < 1 || surface.rows() > most || surface.cols() > most)
    throw InputError("a MetroPro file holds 1 to 65535 rows and columns, not " +
                     std::to_string(surface.rows()) + " × " + std::to_string(surface.cols()));
  // One 32-bit lateral scale serves both axes; its own rounding is the tolerance.
  if (std::abs(surface.dx - surface.dy) > surface.dx * std::numeric_limits<float>::epsilon())
    throw InputError("a MetroPro file has one pitch for both axes, this surface has " +
                     std::to_string(surface.dx) + " × " + std::to_string(surface.dy) + " µm");
  const auto count = static_cast<std::size_t>(surface.z.size());
  if (4 * static_cast<std::uint64_t>(count) > std::numeric_limits<std::uint32_t>::max())
    throw InputError("the surface is too large for a MetroPro file");

  double largest = 0;  // µm
  for (const float z : surface.z.reshaped<Eigen::RowMajor>())
    if (!is_missing(z)) largest = std::max(largest, std::abs(surface.mean + static_cast<double>(z)));
  // The step is S·W·O/R with O = 1, R = 131072 and a wavelength that people expect; S is what makes the
  // largest height fit, rounded up, for it is a 32-bit float.
  constexpr double highest_count = kZygoMissing - 1000;
  constexpr float wavelength = 5.7e-7F;
  constexpr double steps_per_wave = 131072;
  constexpr float smallest_scale = 1e-30F;  // of a flat surface at z = 0
  const double scale = largest * 1e-6 / highest_count * steps_per_wave / static_cast<double>(wavelength);
  const float scale_factor =
      std::max(smallest_scale, std::nextafter(static_cast<float>(scale), std::numeric_limits<float>::max()));
  const double step = zygo_step(
      path,
      {.interferometric = scale_factor, .wavelength = wavelength, .obliquity = 1, .phase_res = 2, .sign = 0});

  std::vector<std::byte> bytes(kHeaderBytes + 4 * count);
  set_field<std::uint32_t>(bytes, kMagic, kMagic1);
  set_field<std::uint16_t>(bytes, kFormat, 1);
  set_field<std::uint32_t>(bytes, kHeaderSize, kHeaderBytes);
  set_field(bytes, kPhaseWidth, static_cast<std::uint16_t>(surface.cols()));
  set_field(bytes, kPhaseHeight, static_cast<std::uint16_t>(surface.rows()));
  set_field(bytes, kPhaseBytes, static_cast<std::uint32_t>(4 * count));
  set_field(bytes, kScaleFactor, scale_factor);
  set_field(bytes, kWavelength, wavelength);
  set_field(bytes, kWavelength1, wavelength);
  set_field(bytes, kObliquity, 1.F);
  set_field(bytes, kLateralRes, static_cast<float>(surface.dx * 1e-6));
  set_field<std::int16_t>(bytes, kPhaseRes, 2);
  set_field(bytes, kCameraWidth, static_cast<std::uint16_t>(surface.cols()));
  set_field(bytes, kCameraHeight, static_cast<std::uint16_t>(surface.rows()));
  std::byte* phase = bytes.data() + kHeaderBytes;
  for (const float z : surface.z.reshaped<Eigen::RowMajor>()) {
    const std::int32_t raw =
        is_missing(z)
            ? kZygoMissing
            : static_cast<std::int32_t>(std::lround((surface.mean + static_cast<double>(z)) / step));
    store(phase, raw, std::endian::big);
    phase += sizeof raw;
  }
  write_file(path, bytes);
}

}  // namespace micro
