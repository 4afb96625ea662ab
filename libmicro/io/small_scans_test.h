#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "height/height_field.h"

// Small scans for tests, made without the code under test.
namespace micro {

std::vector<std::byte> read_bytes(const std::filesystem::path& path);
void write_bytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes);
void write_text(const std::filesystem::path& path, const std::string& text);

/// Puts a number into bytes, the most significant byte first if `big`.
template <typename T>
void put(std::vector<std::byte>& bytes, std::size_t at, T value, bool big) {
  std::array<std::byte, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  if (big) std::reverse(raw.begin(), raw.end());
  std::copy(raw.begin(), raw.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

/// A MetroPro file: 4 columns, 3 rows, raw k·1000 − 3000 except raw 5, which is missing; 2 × 3 intensities in
/// two buckets before them; S = 0.5, W = 0.5 µm, O = 2, pitch 0.25 µm.
struct DatHeader {
  int format = 1;
  int phase_res = 1;
  int sign = 0;
  float lateral = 0.25e-6F;
  float wavelength = 0.5e-6F;
};
std::vector<std::byte> small_dat(const DatHeader& header);

/// Zygo ASCII, 3 columns, 2 rows: raw 32768, −32768, 0, missing, 65536, 1; S·W·O/R = 0.5·2e-6/32768 m; pitch
/// 0.25 µm.
std::string small_asc(const std::string& intensities, int sign = 0);
/// Zygo XYZ of the same size at camera column 10, row 20.
std::string small_xyz();

/// Digital Surf of 3 columns and 2 rows: raw 10, 20, 30, 40, 50, and 8 = zmin − 2.
struct Surf {
  bool macintosh = false;
  int bits = 16;
  int special_points = 1;
  std::string dz_unit = "nm";
};
std::vector<std::byte> small_surf(const Surf& surf);
/// The same file, in PC byte order, with its points in two compressed streams.
std::vector<std::byte> compressed_surf(const std::vector<std::byte>& plain, std::size_t point_bytes);

}  // namespace micro
