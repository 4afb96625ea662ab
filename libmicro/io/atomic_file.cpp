#include "io/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/error.h"

namespace micro {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = ".microbrdf-", kSuffix = ".part";

std::string reason(int error) {
  return std::generic_category().message(error);
}

class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags) : fd_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  int close() { return ::close(std::exchange(fd_, -1)); }

 private:
  int fd_;
};

/// Makes an empty file that nobody else has, in `folder`. The name does not depend on the final one, so it is
/// never too long.
fs::path make_temporary(const fs::path& path, const fs::path& folder) {
  static std::atomic<unsigned> count{0};
  for (;;) {
    fs::path name = folder / temporary_name(std::to_string(::getpid()) + "-" + std::to_string(count++));
    if (Descriptor file(name, O_WRONLY | O_CREAT | O_EXCL); file.get() >= 0) return name;
    if (errno != EEXIST) throw FileError(path, "cannot be written: " + reason(errno));
  }
}

}  // namespace

std::string temporary_name(const std::string& distinction) {
  return std::string(kPrefix) + distinction + std::string(kSuffix);
}

bool is_temporary(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with(kPrefix) && name.ends_with(kSuffix);
}

AtomicFile::AtomicFile(const fs::path& path) : path_(path), target_(path) {
  std::error_code error;
  if (fs::is_symlink(path, error)) {
    target_ = fs::weakly_canonical(path, error);
    if (error) throw FileError(path, "cannot be written: " + error.message());
  }
  if (!target_.has_filename()) throw FileError(path, "cannot be written: the name of a file is missing");
  const fs::file_status status = fs::status(target_, error);
  if (status.type() == fs::file_type::none)  // such as a name that is too long
    throw FileError(path, "cannot be written: " + error.message());
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw FileError(path, "is not a regular file, so it is not replaced");
  const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error))
    throw FileError(path, "cannot be written: the folder " + folder.string() + " does not exist");
  temporary_ = make_temporary(path, folder);
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})) {}

AtomicFile::~AtomicFile() {
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove(temporary_, ignored);
}

void AtomicFile::commit() {
  {
    Descriptor file(temporary_, O_RDWR);
    if (file.get() < 0 || ::fsync(file.get()) != 0 || file.close() != 0)
      throw FileError(path_, "cannot be written: " + reason(errno));
  }
  if (::rename(temporary_.c_str(), target_.c_str()) != 0)
    throw FileError(path_, "cannot be written: " + reason(errno));
  temporary_.clear();
  // The rename itself reaches the disk with its folder. Some file systems refuse to sync one: the file is
  // whole in either case, so that is no failure.
  const Descriptor folder(target_.has_parent_path() ? target_.parent_path() : fs::path("."),
                          O_RDONLY | O_DIRECTORY);
  if (folder.get() >= 0) ::fsync(folder.get());
}

void require_writable(std::span<const fs::path> files, std::span<const fs::path> inputs) {
  const auto place = [](const fs::path& path) {
    std::error_code error;
    const fs::path whole = fs::weakly_canonical(fs::absolute(path, error), error);
    return error ? path : whole;
  };
  std::map<fs::path, const char*> taken;
  for (const fs::path& input : inputs)
    taken.emplace(place(input), "is read, so it is not replaced");
  for (const fs::path& file : files) {
    const auto found = taken.emplace(place(file), "would be written twice");
    if (!found.second) throw FileError(file, found.first->second);
    const AtomicFile probe(file);
  }
}

void write_file(const fs::path& path, std::span<const std::byte> bytes) {
  AtomicFile file(path);
  Descriptor out(file.temporary(), O_WRONLY);
  while (out.get() >= 0 && !bytes.empty()) {
    const ssize_t written = ::write(out.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw FileError(path, "cannot be written: " + reason(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  if (out.get() < 0 || out.close() != 0) throw FileError(path, "cannot be written: " + reason(errno));
  file.commit();
}

}  // namespace micro
