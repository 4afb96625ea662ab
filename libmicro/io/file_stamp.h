#pragma once

#include <cstdint>
#include <filesystem>

namespace micro {

/// What is different after a file was written to, or another was put in its place. The file system's clock
/// has steps of some milliseconds: what is overwritten within one of them at the same size is not seen.
struct FileStamp {
  std::uint64_t device, inode, size;
  std::int64_t seconds, nanoseconds;  ///< when it was last written to
  bool operator==(const FileStamp&) const = default;
};

/// Throws FileError if the file is not there.
FileStamp stamp_of(const std::filesystem::path& path);

}  // namespace micro
