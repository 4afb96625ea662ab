#include "kirchhoff/term_tables.h"

#include <algorithm>
#include <cmath>

namespace micro {

std::int64_t function_entries(double reach) {
  // The cubic's error is (phase step)⁴/384: 4e-8 at 1/16 rad.
  constexpr double kPhaseStep = 1.0 / 16, kMost = 1e9;
  return static_cast<std::int64_t>(std::min(std::ceil(2 * reach / kPhaseStep), kMost)) + 16;
}

double coefficient_entries(double reach, double tolerance) {
  // The error of linear interpolation is (phase step)²/8.
  return std::ceil(reach / std::sqrt(8 * tolerance / 10)) + 16;
}

std::int64_t table_bytes(const TermTables& tables, std::int64_t sum_bytes) {
  return tables.entries() * 2 * (static_cast<std::int64_t>(sizeof(double)) + sum_bytes);
}

int terms_of_a_pass(std::int64_t spectra_bytes, std::int64_t table_bytes, std::int64_t most_bytes) {
  constexpr std::int64_t kTableBytes = std::int64_t{1} << 28, kFewest = 8, kMost = 96;
  return static_cast<int>(
      std::clamp(std::min(most_bytes / spectra_bytes, kTableBytes / table_bytes), kFewest, kMost));
}

double table_work(const BasisSize& basis, const TermTables& tables) {
  // An entry's own: to be worked out, turned into what sums are kept in, and put in its place.
  constexpr double kEntry = 200, kDecomposition = 12;
  const double f = static_cast<double>(tables.functions), c = static_cast<double>(tables.coefficients),
               m = basis.waves;
  return basis.terms * (f * (4 * m + kEntry) + c * (2 * m + kEntry)) +
         kDecomposition * std::pow(basis.decomposed, 3);
}

}  // namespace micro
