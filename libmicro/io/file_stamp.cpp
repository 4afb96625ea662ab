#include "io/file_stamp.h"

#include <sys/stat.h>

#include <cerrno>
#include <system_error>

#include "core/error.h"

namespace micro {

FileStamp stamp_of(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0)
    throw FileError(path, errno == ENOENT ? "does not exist"
                                          : "cannot be read: " + std::generic_category().message(errno));
  return {.device = status.st_dev,
          .inode = status.st_ino,
          .size = static_cast<std::uint64_t>(status.st_size),
          .seconds = status.st_mtim.tv_sec,
          .nanoseconds = status.st_mtim.tv_nsec};
}

}  // namespace micro
