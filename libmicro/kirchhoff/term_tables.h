#pragma once

#include <cstdint>

#include "kirchhoff/height_basis.h"

namespace micro {

/// Entries that one thread makes at a time.
inline constexpr std::int64_t kEntryBlock = 256;

/// Tables that the terms of a HeightBasis are read from: φ_k by cubics, c_k by straight lines.
struct TermTables {
  std::int64_t functions = 0;     ///< entries of φ_k, over all heights
  std::int64_t coefficients = 0;  ///< entries of c_k, over all q_z
  std::int64_t entries() const { return functions + coefficients; }
};

/// Entries of φ_k for heights that turn phases by ±`reach` rad.
std::int64_t function_entries(double reach);

/// Entries of c_k that leave a tenth of `tolerance` when they are read by straight lines.
double coefficient_entries(double reach, double tolerance);

/// Bytes of one term's tables while they are made: doubles, and numbers of `sum_bytes` that sums are kept in.
std::int64_t table_bytes(const TermTables& tables, std::int64_t sum_bytes);

/// Terms of one pass over the surface whose spectra take `spectra_bytes` each and tables `table_bytes` each,
/// where spectra may take `most_bytes` together: 8 to 96, what bounds the memory.
int terms_of_a_pass(std::int64_t spectra_bytes, std::int64_t table_bytes, std::int64_t most_bytes);

/// Multiply-adds that making the tables of a whole basis takes, its decomposition included, about.
double table_work(const BasisSize& basis, const TermTables& tables);

}  // namespace micro
