#include "io/bytes.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <string>
#include <system_error>

namespace micro {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, int error) {
  throw FileError(path, "cannot be read: " + std::generic_category().message(error));
}

}  // namespace

FileBytes::FileBytes(const fs::path& path, std::uintmax_t most) : path_(path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) throw FileError(path, "does not exist");
  if (error) fail(path, error.value());
  if (fs::is_directory(status)) throw FileError(path, "is a folder");
  if (!fs::is_regular_file(status)) throw FileError(path, "is not a regular file");
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) fail(path, errno);
  file_size_ = fs::file_size(path, error);
  const auto wanted = static_cast<std::size_t>(std::min(file_size_, most));
  if (!error) data_ = std::make_unique_for_overwrite<std::byte[]>(wanted);
  int failure = error ? error.value() : 0;
  while (failure == 0 && size_ < wanted) {
    const ssize_t count = ::read(fd, data_.get() + size_, wanted - size_);
    if (count == 0) break;
    if (count > 0) size_ += static_cast<std::size_t>(count);
    if (count < 0 && errno != EINTR) failure = errno;
  }
  ::close(fd);
  if (failure != 0) fail(path, failure);
  if (size_ < wanted) throw FileError(path, "became shorter while it was read");
}

bool begins_with(std::span<const std::byte> bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

Pitch user_pitch(const fs::path& path, const ReadOptions& options) {
  if (!options.pitch_x)
    throw FileError(path, "does not say how far apart its points are; give it with --pitch (0.11um, or X,Y)");
  return {*options.pitch_x, options.pitch_y.value_or(*options.pitch_x)};
}

Pitch file_pitch(const fs::path& path, Pitch own, const ReadOptions& options) {
  if (own.dx == 0 || own.dy == 0) return user_pitch(path, options);
  if (!(own.dx > 0 && own.dy > 0 && std::isfinite(own.dx) && std::isfinite(own.dy)))
    throw FileError(path, "its lateral scale makes no sense: " + std::to_string(own.dx) + " × " +
                              std::to_string(own.dy) + " µm");
  return own;
}

}  // namespace micro
