#pragma once

namespace micro {

/// Multiply-adds of doubles that one thread does in a second when it does nothing else, in the widest vectors
/// of this machine; measured now.
double peak_multiply_adds();

/// Bytes that one thread reads and writes in a second when it copies what no cache holds; measured now.
double copy_bandwidth();

}  // namespace micro
