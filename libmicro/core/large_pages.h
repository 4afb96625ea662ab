#pragma once

#include <cstddef>

namespace micro {

/// Asks the system to give memory that nobody has touched yet in pages of 2 MB, where it is large enough to
/// hold some: a hundred megabytes of small pages take longer to come than to fill. A wish, without effect on
/// any number.
void prefer_large_pages(void* begin, std::size_t bytes);

}  // namespace micro
