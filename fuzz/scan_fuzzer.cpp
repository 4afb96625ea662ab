// The libFuzzer targets, one for each reader: the program is called fuzz_FORMAT, by a format's name in the
// table. Any bytes are a scan or a FileError.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <new>
#include <string>

#include "core/error.h"
#include "io/bytes.h"
#include "io/scan.h"

// What the child process's limit does to a library that believes a header: std::bad_alloc. (AddressSanitizer's own
// operator ends the program.)
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

/// A file in memory, under the same name for every input.
int memory_file() {
  static const int file = memfd_create("scan", 0);
  return file;
}

/// The format that the program is named after.
const micro::ScanFormat* format = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** argv) {
  const std::string program = std::filesystem::path((*argv)[0]).filename();
  for (const micro::ScanFormat& known : micro::scan_formats())
    if (program == "fuzz_" + std::string(known.name)) format = &known;
  require(format != nullptr);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path path = "/proc/self/fd/" + std::to_string(memory_file());
  require(ftruncate(memory_file(), 0) == 0);
  require(pwrite(memory_file(), data, size, 0) == static_cast<ssize_t>(size));
  const micro::FileBytes head(path, micro::kHeadBytes);
  if (!format->recognise({.path = path, .size = head.file_size(), .bytes = head.bytes()})) return 0;
  try {
    const micro::HeightField surface = format->read(path, {.pitch_x = 0.25, .pitch_y = {}});
    require(surface.z.size() > 0 && surface.dx > 0 && surface.dy > 0);
    require(!surface.z.isInf().any());
  } catch (const micro::FileError& error) {
    require(error.file() == path);
  } catch (const std::bad_alloc&) {
    // read_scan makes a sentence of it.
  }
  return 0;
}
