#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/error.h"
#include "height/height_field.h"
#include "io/scan.h"

namespace micro {

/// The bytes of a file, or of its beginning.
class FileBytes {
 public:
  /// Reads the whole file, or its first `most` bytes. Throws FileError.
  explicit FileBytes(const std::filesystem::path& path, std::uintmax_t most = UINTMAX_MAX);

  const std::filesystem::path& path() const { return path_; }
  std::uintmax_t file_size() const { return file_size_; }
  std::size_t size() const { return size_; }
  const std::byte* data() const { return data_.get(); }
  std::span<const std::byte> bytes() const { return {data_.get(), size_}; }
  std::string_view text() const { return {reinterpret_cast<const char*>(data_.get()), size_}; }

  /// Throws FileError with `fact` unless `condition` holds.
  void require(bool condition, const char* fact) const {
    if (!condition) throw FileError(path_, fact);
  }

 private:
  std::filesystem::path path_;
  std::uintmax_t file_size_ = 0;
  std::size_t size_ = 0;
  std::unique_ptr<std::byte[]> data_;
};

/// The T (an integer or float of 1, 2, 4 or 8 bytes) that stands at `at` in the given byte order.
template <typename T>
T load(const std::byte* at, std::endian order) {
  if constexpr (sizeof(T) == 1) {
    return std::bit_cast<T>(*at);
  } else if constexpr (sizeof(T) == 2) {
    std::uint16_t bits;
    std::memcpy(&bits, at, sizeof bits);
    return std::bit_cast<T>(order == std::endian::native ? bits : __builtin_bswap16(bits));
  } else if constexpr (sizeof(T) == 4) {
    std::uint32_t bits;
    std::memcpy(&bits, at, sizeof bits);
    return std::bit_cast<T>(order == std::endian::native ? bits : __builtin_bswap32(bits));
  } else {
    std::uint64_t bits;
    std::memcpy(&bits, at, sizeof bits);
    return std::bit_cast<T>(order == std::endian::native ? bits : __builtin_bswap64(bits));
  }
}

/// Puts a T at `at` in the given byte order.
template <typename T>
void store(std::byte* at, T value, std::endian order) {
  std::memcpy(at, &value, sizeof value);
  const T ordered = load<T>(at, order);
  std::memcpy(at, &ordered, sizeof ordered);
}

/// True if the bytes begin with `magic`.
bool begins_with(std::span<const std::byte> bytes, std::string_view magic);

/// Distances between columns and rows, µm.
struct Pitch {
  double dx;
  double dy;
};

/// The user's pitch for a file whose own lateral scale is unknown. Throws FileError asking for it if there is
/// none.
Pitch user_pitch(const std::filesystem::path& path, const ReadOptions& options);

/// The pitch that a file gives, in µm. 0 means that the instrument did not know it: then the user's is taken.
/// Anything else that is not positive and finite is a FileError.
Pitch file_pitch(const std::filesystem::path& path, Pitch own, const ReadOptions& options);

/// sample_height_field for the contents of a file: what it refuses is a FileError.
template <typename Height>
HeightField read_height_field(const std::filesystem::path& path, std::uint64_t rows, std::uint64_t cols,
                              Pitch pitch, Height&& height) {
  if (rows == 0 || cols == 0) throw FileError(path, "holds no heights");
  try {
    return sample_height_field(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols), pitch.dx,
                               pitch.dy, height);
  } catch (const InputError& error) {
    throw FileError(path, error.what());
  }
}

}  // namespace micro
