#pragma once

#include <filesystem>

namespace micro {

/// Holds an output folder, or one output file, for one run at a time. The lock is the kernel's: it goes when
/// its process does, however that ends, and a run that ends by itself leaves no file behind.
class OutputLock {
 public:
  /// Makes the folder if need be and takes all of it. Throws FileError if another run holds it, or a file in
  /// it, or it cannot be made.
  explicit OutputLock(const std::filesystem::path& folder);
  ~OutputLock();
  OutputLock(OutputLock&& other) noexcept;
  OutputLock& operator=(OutputLock&&) = delete;

  /// Takes one file in a folder that is there: other files of the folder stay free for other runs. Throws
  /// FileError if another run holds the file or its folder.
  static OutputLock of_file(const std::filesystem::path& file);

 private:
  OutputLock() = default;
  std::filesystem::path made_;   // the folder, if this made it
  std::filesystem::path guard_;  // stands for the file: outputs are replaced, so they cannot hold a lock
  int folder_ = -1, file_ = -1;  // descriptors
};

}  // namespace micro
