#pragma once

#include <filesystem>

namespace micro {

/// Holds an output folder for one run at a time. The lock is the kernel's: it goes when its process does,
/// however that ends, and leaves no file behind.
class OutputLock {
 public:
  /// Makes the folder if need be and takes it. Throws FileError if another run holds it or it cannot be made.
  explicit OutputLock(const std::filesystem::path& folder);
  ~OutputLock();
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;

 private:
  std::filesystem::path made_;  // the folder, if this made it
  int descriptor_;
};

}  // namespace micro
