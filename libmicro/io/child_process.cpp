#include "io/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "core/error.h"
#include "io/printable.h"

namespace micro {
namespace {

/// How a child ends that is still in command of itself; no library exits with these.
enum Exit : int { kDone = 81, kRefused = 82 };

constexpr rlim_t kAddressSpace = rlim_t{2} << 30;
constexpr rlim_t kLeastRoom = rlim_t{512} << 20;  ///< beyond what the parent has mapped already
/// Bytes that one byte of a file may become on the way: a small file that asks for a gigabyte lies.
constexpr rlim_t kInflation = 64;

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// Lowers a limit; one that is lower already stays.
void limit(decltype(RLIMIT_AS) resource, rlim_t value) {
  rlimit now{};
  if (::getrlimit(resource, &now) != 0) return;
  now.rlim_cur = std::min(now.rlim_cur, value);
  now.rlim_max = std::min(now.rlim_max, now.rlim_cur + (resource == RLIMIT_CPU ? 1 : 0));
  ::setrlimit(resource, &now);
}

/// Address space in use, bytes.
rlim_t mapped_bytes() {
  unsigned long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return rlim_t{pages} * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
}

/// What the child does before anything else.
void confine(const ChildLimits& limits, std::uintmax_t file_size, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU, SIGINT, SIGTERM})
    ::signal(number, SIG_DFL);
  // A library that finds its memory broken says so on stderr, in its own words.
  if (const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC); null >= 0) {
    ::dup2(null, STDOUT_FILENO);
    ::dup2(null, STDERR_FILENO);
  }
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, static_cast<rlim_t>(std::ceil(limits.processor_seconds)));
  const rlim_t least = mapped_bytes() + kLeastRoom, size{file_size};
  limit(RLIMIT_AS, std::max(least, std::min(kAddressSpace, least + kInflation * size)) + 4 * size);
}

[[noreturn]] void live_as_child(ChildOutput& output, const std::filesystem::path& path,
                                const std::function<void(ChildOutput&)>& work) {
  constexpr const char* no_memory = "needs more memory than a scan of its size should";
  const auto refuse = [&](const char* fact) {
    try {
      output.clear();
      output.write(fact, std::char_traits<char>::length(fact));
    } catch (...) {
      ::_exit(1);
    }
    ::_exit(kRefused);
  };
  try {
    work(output);
  } catch (const FileError& error) {
    refuse(error.file() == path ? error.fact().c_str() : error.what());
  } catch (const std::bad_alloc&) {
    refuse(no_memory);
  } catch (const std::exception& error) {
    refuse(error.what());
  } catch (...) {
    refuse("cannot be read, and nobody says why");
  }
  ::_exit(kDone);
}

using Clock = std::chrono::steady_clock;

/// Waits for the child; kills it at the deadline. Returns its status as waitpid gives it, or nothing if it
/// was killed.
std::optional<int> wait_for(pid_t child, Clock::time_point deadline) {
  // A pidfd would do without the naps, but not in every container.
  auto nap = std::chrono::microseconds(50);
  for (;;) {
    int status = 0;
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child) return status;
    if (ended < 0 && errno != EINTR) return std::nullopt;
    if (Clock::now() > deadline) break;
    std::this_thread::sleep_for(nap);
    nap = std::min(nap * 5 / 4, std::chrono::microseconds(5000));
  }
  ::kill(child, SIGKILL);
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
  return std::nullopt;
}

}  // namespace

ChildOutput::ChildOutput() : file_(::memfd_create("microbrdf", MFD_CLOEXEC)) {
  if (file_ < 0) fail("memory for a child process");
}

ChildOutput::~ChildOutput() {
  if (file_ >= 0) ::close(file_);
}

ChildOutput::ChildOutput(ChildOutput&& other) noexcept
    : file_(std::exchange(other.file_, -1)), at_(other.at_) {}

void ChildOutput::write(const void* bytes, std::size_t size) {
  const auto* from = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t count = ::write(file_, from, size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail("writing to the parent process");
    from += count;
    size -= static_cast<std::size_t>(count);
  }
}

void ChildOutput::clear() {
  if (::ftruncate(file_, 0) != 0 || ::lseek(file_, 0, SEEK_SET) != 0) fail("writing to the parent process");
}

void ChildOutput::read(void* bytes, std::size_t size) {
  auto* to = static_cast<char*>(bytes);
  while (size > 0) {
    const ssize_t count = ::pread(file_, to, size, static_cast<off_t>(at_));
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) errno = ENODATA;
    if (count <= 0) fail("reading from a child process");
    to += count;
    at_ += static_cast<std::size_t>(count);
    size -= static_cast<std::size_t>(count);
  }
}

std::size_t ChildOutput::remaining() const {
  struct stat status {};
  if (::fstat(file_, &status) != 0) fail("reading from a child process");
  return static_cast<std::size_t>(status.st_size) - at_;
}

ChildOutput run_in_child(const std::filesystem::path& path, const ChildLimits& limits,
                         const std::function<void(ChildOutput&)>& work) {
  std::error_code ignored;
  std::uintmax_t size = std::filesystem::file_size(path, ignored);
  if (ignored) size = 0;  // whoever opens it will say what is wrong
  ChildOutput output;
  const pid_t parent = ::getpid();
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(limits.seconds));
  const pid_t child = ::fork();
  if (child < 0) fail("starting a child process");
  if (child == 0) {
    confine(limits, size, parent);
    live_as_child(output, path, work);
  }
  const std::optional<int> status = wait_for(child, deadline);
  if (!status || (WIFSIGNALED(*status) && WTERMSIG(*status) == SIGXCPU))
    throw FileError(path, "takes longer to read than a scan of its size should");
  if (WIFSIGNALED(*status))
    throw FileError(path, "is broken: it crashed the library that reads its format (signal " +
                              std::to_string(WTERMSIG(*status)) + ")");
  if (WIFEXITED(*status) && WEXITSTATUS(*status) == kDone) return output;
  if (!WIFEXITED(*status) || WEXITSTATUS(*status) != kRefused)
    throw FileError(path, "is broken: the library that reads its format gave up");
  constexpr std::size_t most = 500;  // bytes of a sentence
  std::string fact(std::min(output.remaining(), most + 1), '\0');
  output.read(fact.data(), fact.size());
  throw FileError(path, printable(fact, most));  // it may quote the file
}

}  // namespace micro
