#include "io/small_scans_test.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>

namespace micro {

std::vector<std::byte> read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), {});
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

void write_bytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

std::vector<std::byte> small_dat(const DatHeader& header) {
  const std::size_t header_bytes = header.format == 3 ? 4096 : 834;
  constexpr std::size_t intensity_bytes = 2 * 2 * 3 * 2, points = 12;
  std::vector<std::byte> bytes(header_bytes + intensity_bytes + 4 * points, std::byte{0x11});
  std::fill_n(bytes.begin(), header_bytes, std::byte{0});
  put(bytes, 0, 0x881B036E + static_cast<std::uint32_t>(header.format), true);
  put(bytes, 4, static_cast<std::uint16_t>(header.format), true);
  put(bytes, 6, static_cast<std::uint32_t>(header_bytes), true);
  put<std::uint16_t>(bytes, 52, 2, true);
  put<std::uint16_t>(bytes, 54, 3, true);
  put<std::uint16_t>(bytes, 56, 2, true);
  put<std::uint32_t>(bytes, 60, intensity_bytes, true);
  put<std::uint16_t>(bytes, 68, 4, true);
  put<std::uint16_t>(bytes, 70, 3, true);
  put<std::uint32_t>(bytes, 72, 4 * points, true);
  put(bytes, 164, 0.5F, true);
  put(bytes, 168, header.wavelength, true);
  put(bytes, 176, 2.F, true);
  put(bytes, 184, header.lateral, true);
  put(bytes, 218, static_cast<std::int16_t>(header.phase_res), true);
  put(bytes, 232, static_cast<std::int16_t>(header.sign), true);
  for (std::size_t k = 0; k < points; ++k)
    put(bytes, header_bytes + intensity_bytes + 4 * k,
        k == 5 ? 2147483640 : static_cast<std::int32_t>(k) * 1000 - 3000, true);
  return bytes;
}

std::string small_asc(const std::string& intensities, int sign) {
  const std::string buckets = intensities.empty() ? "0" : "1";
  return "Zygo ASCII Data File - Format 2\n1 8 1 5 \"Mon Oct 31 13:29:09 2005     \"\n0 0 2 2 " + buckets +
         " 255\n0 0 3 2\n\"a # b\"\n\"c\"\n\"d\"\n0 0.5 2e-006 0 1 0 2.5e-007 1421361442\n"
         "640 480 22 0 59233 0 \" 20X  Mirau\"\n2 0 0 0 0 0 0 30.074 1 0\n1 0 7 1 60 0 0 " +
         std::to_string(sign) + " 0\n0 \"  \"\n1 0\n\"   2X  \"\n#\n" + intensities +
         "32768 -32768 0 2147483640 \n65536 1 \n#\n";
}

std::string small_xyz() {
  return "Zygo XYZ Data File - Format 1\n1 8 1 5 \"Mon Oct 31 13:29:09 2005     \"\n0 0 0 0 0 255\n10 20 3 "
         "2\n"
         "\"a\"\n\"c\"\n\"d\"\n0 0.5 2e-006 0 1 0 2.5e-007 1421361442\n640 480 22 0 59233 0 \" 20X  Mirau\"\n"
         "2 0 0 0 0 0 0 30.074 1 0\n1 0 7 1 60 0 0 0 0\n0 \"  \"\n1 0\n#\n"
         "10 20 0.5\n11 20 -1.25e-001\n12\t20\tNo Data\n10 21 2\n11 21 3\n12 21 4\n#\n";
}

std::vector<std::byte> small_surf(const Surf& surf) {
  const std::array raw = {10, 20, 30, 40, 50, 8};
  const auto bytes_each = static_cast<std::size_t>(surf.bits / 8);
  const bool big = surf.macintosh;
  constexpr std::size_t header = 512, comment = 7, own = 5;
  std::vector<std::byte> bytes(header + comment + own + raw.size() * bytes_each, std::byte{0});
  const auto text = [&](std::size_t at, const std::string& value, std::size_t size) {
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), size, std::byte{' '});
    std::memcpy(bytes.data() + at, value.data(), value.size());
  };
  text(0, "DIGITAL SURF", 12);
  put<std::int16_t>(bytes, 12, big ? 257 : 0, big);
  put<std::int16_t>(bytes, 14, 1, big);
  put<std::int16_t>(bytes, 18, 2, big);
  put(bytes, 86, static_cast<std::int16_t>(surf.special_points), big);
  put(bytes, 98, static_cast<std::int16_t>(surf.bits), big);
  put<std::int32_t>(bytes, 100, 10, big);
  put<std::int32_t>(bytes, 104, 50, big);
  put<std::int32_t>(bytes, 108, 3, big);
  put<std::int32_t>(bytes, 112, 2, big);
  put<std::int32_t>(bytes, 116, 6, big);
  put(bytes, 120, 0.25F, big);
  put(bytes, 124, 0.5e-3F, big);
  put(bytes, 128, 0.5F, big);
  text(180, "\xB5m", 16);
  text(196, "mm", 16);
  text(212, surf.dz_unit, 16);
  put<std::uint16_t>(bytes, 334, comment, big);
  put<std::uint16_t>(bytes, 336, own, big);
  put(bytes, 474, 100.F, big);
  for (std::size_t k = 0; k < raw.size(); ++k) {
    const std::size_t at = header + comment + own + k * bytes_each;
    if (surf.bits == 16)
      put(bytes, at, static_cast<std::int16_t>(raw[k]), big);
    else
      put<std::int32_t>(bytes, at, raw[k], big);
  }
  return bytes;
}

std::vector<std::byte> compressed_surf(const std::vector<std::byte>& plain, std::size_t point_bytes) {
  std::vector<std::byte> bytes(plain.begin(), plain.end() - static_cast<std::ptrdiff_t>(point_bytes));
  std::memcpy(bytes.data(), "DSCOMPRESSED", 12);
  const std::size_t directory = bytes.size(), half = point_bytes / 2;
  bytes.resize(directory + 4 + 2 * 8);
  put<std::uint32_t>(bytes, directory, 2, false);
  for (std::size_t stream = 0; stream < 2; ++stream) {
    std::array<Bytef, 200> packed;
    uLongf size = packed.size();
    compress(packed.data(), &size,
             reinterpret_cast<const Bytef*>(plain.data() + plain.size() - point_bytes + stream * half), half);
    put(bytes, directory + 4 + 8 * stream, static_cast<std::uint32_t>(half), false);
    put(bytes, directory + 8 + 8 * stream, static_cast<std::uint32_t>(size), false);
    const auto* begin = reinterpret_cast<const std::byte*>(packed.data());
    bytes.insert(bytes.end(), begin, begin + size);
  }
  return bytes;
}

}  // namespace micro
