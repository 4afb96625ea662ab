#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace micro {

/// A file that is whole or absent: it is written beside its final name, brought to the disk and renamed.
/// Whoever stops before commit() (an exception, a kill, a full disk) leaves the old file, or none, under that
/// name.
class AtomicFile {
 public:
  /// Makes an empty temporary file in the folder of `path`. Throws FileError if that cannot be done, or if
  /// `path` is there and is no regular file, or can be no name. A symbolic link is followed: its target is
  /// replaced.
  explicit AtomicFile(const std::filesystem::path& path);
  ~AtomicFile();  ///< removes the temporary file unless it was committed
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& temporary() const { return temporary_; }

  /// Flushes the temporary file to the disk and gives it the final name. Throws FileError.
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path target_;  // path_ with symbolic links followed
  std::filesystem::path temporary_;
};

/// Refuses, before anything is computed, files that could not be written afterwards: those for which an
/// AtomicFile cannot be made, and those that would replace one another or one of `inputs`. Throws FileError.
void require_writable(std::span<const std::filesystem::path> files,
                      std::span<const std::filesystem::path> inputs = {});

/// The name of a file that lives no longer than the run that makes it.
std::string temporary_name(const std::string& distinction);

/// Is this such a name? AtomicFile's temporary files have one.
bool is_temporary(const std::filesystem::path& path);

/// Writes the bytes as a whole file. Throws FileError.
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// The same of a text.
inline void write_text_file(const std::filesystem::path& path, const std::string& text) {
  write_file(path, std::as_bytes(std::span(text)));
}

}  // namespace micro
