#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <type_traits>

namespace micro {

/// Memory that a child process leaves behind: written in order by the child, read in order by its parent.
class ChildOutput {
 public:
  ChildOutput();
  ~ChildOutput();
  ChildOutput(ChildOutput&& other) noexcept;
  ChildOutput& operator=(ChildOutput&&) = delete;

  /// Both throw std::system_error if the memory cannot be had; read also if there are fewer bytes.
  void write(const void* bytes, std::size_t size);
  void read(void* bytes, std::size_t size);
  /// Forgets what was written.
  void clear();

  template <typename T>
  void write_value(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    write(&value, sizeof value);
  }
  template <typename T>
  T read_value() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    read(&value, sizeof value);
    return value;
  }

  /// Bytes that read has not reached yet.
  std::size_t remaining() const;

 private:
  int file_ = -1;
  std::size_t at_ = 0;
};

/// How long a child may take; its memory is limited as well.
struct ChildLimits {
  double processor_seconds;
  double seconds;
};

/// Runs work(output) in a child process, a copy of this one with the calling thread alone, and returns what
/// it wrote. For libraries that a file may crash: the child has 512 MiB of address space beyond its parent's
/// and 64 times the file's size, together at most 2 GiB, and four times the file's size (beside what the
/// sanitizers reserve), no core file, nothing to print on, and dies with its parent. What `work` throws
/// becomes a FileError about `path` here (a FileError keeps its fact), and so does the child's death. `work`
/// must not start threads.
ChildOutput run_in_child(const std::filesystem::path& path, const ChildLimits& limits,
                         const std::function<void(ChildOutput&)>& work);

}  // namespace micro
