// The libFuzzer targets, one for each reader: the program is called fuzz_FORMAT, by a format's name in the
// table. Any bytes are a scan or a FileError.
#include <hdf5.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <string>

#include "core/error.h"
#include "io/bytes.h"
#include "io/scan.h"
#include "io/small_scans_of_every_format_test.h"

// What the child process's limit does to a library that believes a header: std::bad_alloc.
// (AddressSanitizer's own operator ends the program.)
void* operator new(std::size_t size) {
  constexpr std::size_t kMost = std::size_t{1} << 28;
  void* memory = size <= kMost ? std::malloc(size) : nullptr;
  if (!memory) throw std::bad_alloc();
  return memory;
}
void* operator new[](std::size_t size) {
  return operator new(size);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

/// The file that every input is written to. It has a name: HDF5 asks for the real path of what it opens.
class InputFile {
 public:
  InputFile() : path_(std::filesystem::temp_directory_path() / "fuzz_XXXXXX") {
    std::string name = path_;
    file_ = mkstemp(name.data());
    require(file_ >= 0);
    path_ = name;
  }
  ~InputFile() { std::filesystem::remove(path_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  const std::filesystem::path& path() const { return path_; }
  void write(const void* bytes, std::size_t size) {
    require(ftruncate(file_, 0) == 0);
    require(pwrite(file_, bytes, size, 0) == static_cast<ssize_t>(size));
  }

 private:
  std::filesystem::path path_;
  int file_ = -1;
};

InputFile& input() {
  static InputFile file;
  return file;
}

/// The format that the program is named after.
const micro::ScanFormat* format = nullptr;

/// Whether the input is a scan of the format. Any bytes are one, or refused by a FileError that names the
/// file.
bool reads_input() {
  const std::filesystem::path& path = input().path();
  const micro::FileBytes head(path, micro::kHeadBytes);
  if (!format->recognise({.path = path, .size = head.file_size(), .bytes = head.bytes()})) return false;
  try {
    const micro::HeightField surface = format->read(path, {.pitch_x = 0.25, .pitch_y = {}});
    require(surface.z.size() > 0 && surface.dx > 0 && surface.dy > 0);
    require(!surface.z.isInf().any());
    return true;
  } catch (const micro::FileError& error) {
    require(error.file() == path);
  } catch (const std::bad_alloc&) {
    // read_scan makes a sentence of it.
  }
  return false;
}

/// What is fuzzed must get past the door: small scans of the format are read the way that inputs are.
void require_small_scans_are_read() {
  std::string scratch = std::filesystem::temp_directory_path() / "fuzz_XXXXXX";
  require(mkdtemp(scratch.data()) != nullptr);
  const auto scans = micro::small_scans_of_every_format(scratch);
  std::filesystem::remove_all(scratch);
  for (const auto& bytes : scans.at(std::string(format->name))) {
    input().write(bytes.data(), bytes.size());
    require(reads_input());
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** argv) {
  const std::string program = std::filesystem::path((*argv)[0]).filename();
  for (const micro::ScanFormat& known : micro::scan_formats())
    if (program == "fuzz_" + std::string(known.name)) format = &known;
  require(format != nullptr);
  // HDF5 keeps the megabyte that every open file takes: most of the time went into having it anew.
  require(H5set_free_list_limits(-1, -1, -1, -1, -1, -1) >= 0);
  require_small_scans_are_read();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  input().write(data, size);
  reads_input();
  return 0;
}
