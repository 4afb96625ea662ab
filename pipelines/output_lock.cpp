#include "pipelines/output_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "core/error.h"
#include "io/atomic_file.h"

namespace micro {

OutputLock::OutputLock(const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::create_directories(folder, error)) made_ = folder;
  if (error) throw FileError(folder, "cannot be made: " + error.message());
  descriptor_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0) throw FileError(folder, "is no folder that can be opened");
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    const int reason = errno;
    ::close(descriptor_);
    throw FileError(folder, reason == EWOULDBLOCK
                                ? "is held by another run"
                                : "cannot be locked: " + std::generic_category().message(reason));
  }
  // Nobody else writes here now, so what is unfinished was left by a run that was stopped.
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (is_temporary(entry.path())) std::filesystem::remove(entry.path(), error);
}

OutputLock::~OutputLock() {
  std::error_code not_empty;
  if (!made_.empty()) std::filesystem::remove(made_, not_empty);
  ::close(descriptor_);
}

}  // namespace micro
