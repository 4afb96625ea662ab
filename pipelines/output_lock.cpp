#include "pipelines/output_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <functional>
#include <string>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "io/atomic_file.h"

namespace micro {
namespace {

namespace fs = std::filesystem;

/// flock() without waiting; `output` is what the user calls it.
void take(int descriptor, int kind, const fs::path& output) {
  if (::flock(descriptor, kind | LOCK_NB) == 0) return;
  throw FileError(output, errno == EWOULDBLOCK
                              ? "is held by another run"
                              : "cannot be locked: " + std::generic_category().message(errno));
}

int open_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) throw FileError(folder, "is no folder that can be opened");
  return descriptor;
}

/// Is `descriptor` still what the path leads to? Its last holder may have removed it in between.
bool is_current(int descriptor, const fs::path& path) {
  struct stat held {
  }, named{};
  return ::fstat(descriptor, &held) == 0 && ::stat(path.c_str(), &named) == 0 &&
         held.st_ino == named.st_ino && held.st_dev == named.st_dev;
}

}  // namespace

OutputLock::OutputLock(const fs::path& folder) : OutputLock() {
  std::error_code error;
  if (fs::create_directories(folder, error)) made_ = folder;
  if (error) throw FileError(folder, "cannot be made: " + error.message());
  folder_ = open_folder(folder);
  take(folder_, LOCK_EX, folder);
  // Nobody else writes here now, so what is unfinished was left by a run that was stopped.
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (is_temporary(entry.path())) fs::remove(entry.path(), error);
}

OutputLock OutputLock::of_file(const fs::path& file) {
  std::error_code error;
  const fs::path target = fs::weakly_canonical(fs::absolute(file, error), error);
  if (error || !target.has_filename() || !fs::is_directory(target.parent_path(), error))
    throw FileError(file, "cannot be written: its folder does not exist");
  if (fs::exists(target, error) && !fs::is_regular_file(target, error))
    throw FileError(file, "is not a regular file, so it is not replaced");
  OutputLock lock;
  lock.folder_ = open_folder(target.parent_path());
  take(lock.folder_, LOCK_SH, file);
  const fs::path guard =
      target.parent_path() /
      temporary_name("lock-" + std::to_string(std::hash<std::string>()(target.filename())));
  do {
    if (lock.file_ >= 0) ::close(lock.file_);
    lock.file_ = ::open(guard.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (lock.file_ < 0) throw FileError(file, "cannot be written: " + std::generic_category().message(errno));
    take(lock.file_, LOCK_EX, file);
  } while (!is_current(lock.file_, guard));
  lock.guard_ = guard;
  return lock;
}

OutputLock::OutputLock(OutputLock&& other) noexcept
    : made_(std::exchange(other.made_, {})),
      guard_(std::exchange(other.guard_, {})),
      folder_(std::exchange(other.folder_, -1)),
      file_(std::exchange(other.file_, -1)) {}

OutputLock::~OutputLock() {
  std::error_code ignored;
  if (!guard_.empty()) fs::remove(guard_, ignored);  // before its lock goes
  if (!made_.empty()) fs::remove(made_, ignored);    // if nothing came of it
  if (file_ >= 0) ::close(file_);
  if (folder_ >= 0) ::close(folder_);
}

}  // namespace micro
