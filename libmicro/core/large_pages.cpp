#include "core/large_pages.h"

#include <sys/mman.h>

#include <cstdint>

namespace micro {

void prefer_large_pages(void* begin, std::size_t bytes) {
  constexpr std::size_t kPage = std::size_t{1} << 21, kWorthIt = 2 * kPage;
  if (bytes < kWorthIt) return;
#ifdef MADV_HUGEPAGE
  const std::size_t before = -reinterpret_cast<std::uintptr_t>(begin) % kPage;
  madvise(static_cast<char*>(begin) + before, (bytes - before) / kPage * kPage, MADV_HUGEPAGE);
#endif
}

}  // namespace micro
