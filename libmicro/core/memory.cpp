#include "core/memory.h"

#include <cstdlib>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace micro {

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kMegabyte = 1 << 20;
  // NOLINTBEGIN(concurrency-mt-unsafe): called before there are threads
  mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);  // larger blocks go back at once
  mallopt(M_TRIM_THRESHOLD, 128 * kMegabyte);
  // NOLINTEND(concurrency-mt-unsafe)
#endif
}

}  // namespace micro
