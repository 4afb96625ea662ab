#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

struct zip;

namespace micro {

/// A zip archive, opened for reading. Whatever goes wrong is a FileError.
class ZipArchive {
 public:
  explicit ZipArchive(const std::filesystem::path& path);
  ~ZipArchive();
  ZipArchive(const ZipArchive&) = delete;
  ZipArchive& operator=(const ZipArchive&) = delete;

  /// The names of all members, in the archive's order.
  std::vector<std::string> names() const;

  /// The member of that name, upper and lower case alike, or nothing. `most` is the largest size, in bytes,
  /// that makes sense for it.
  std::optional<std::vector<std::byte>> read(const std::string& name, std::uint64_t most) const;

 private:
  std::filesystem::path path_;
  zip* archive_ = nullptr;
};

/// A file in an archive that is to be written.
struct ZipMember {
  std::string name;
  std::vector<std::byte> bytes;
};

/// Writes the members, deflated and without times, so that equal members make equal archives. The file is
/// whole or absent. Throws FileError.
void write_zip(const std::filesystem::path& path, const std::vector<ZipMember>& members);

}  // namespace micro
