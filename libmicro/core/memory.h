#pragma once

namespace micro {

/// Lets the process keep what it has freed for what it allocates next, up to some hundred megabytes. A batch
/// allocates the same sizes for every scan; fetching them anew, page by page, costs as much as filtering a
/// scan does. To be called before there are threads.
void keep_freed_memory();

}  // namespace micro
