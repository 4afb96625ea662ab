#pragma once

#include <complex>
#include <cstdint>

#include "core/fft.h"

namespace micro {

/// c_k(q_z), halved, two terms k = 2f, 2f+1 for each field f: [fields, entries, 4] = (Re c_2f, Im c_2f,
/// Re c_2f+1, Im c_2f+1)/2. Entries are equidistant in q_z, for linear interpolation, or one for each
/// k_x² + k_y² that occurs, which is less on small tables under great heights.
template <typename Real>
struct CoefficientTable {
  enum class Entries { Equidistant, OfNodes } kind = Entries::Equidistant;
  double low = 0;    ///< rad/µm, q_z of entry 0
  double per_q = 0;  ///< entries per rad/µm, where they are equidistant
  int entries = 0;   ///< ≥ 2
  int fields = 0;
  FftVector<Real> data;
};

/// One quarter-plane's partial sums of F: columns |k_x| = 0 … c, each `stride` numbers for |k_y| = 0 … c and
/// padding.
template <typename Real>
struct QuadrantField {
  FftVector<Real> re, im;
};

/// Sums over terms in four quarter-planes: (+,+), (−,−), (+,−), (−,+) in (k_x, k_y).
template <typename Real>
struct DiskField {
  int half = 0;             ///< c: k runs over −c … c
  std::int64_t stride = 0;  ///< ≥ c + 1 + padding
  QuadrantField<Real> quadrants[4];
};

/// Columns +k_x and −k_x of the spectra of all fields. Field f is the complex image term_2f + i·term_2f+1;
/// its column is `length` + padding numbers, k_y = 0 … length−1 in the transform's order and k_y = 0 again at
/// the end.
template <typename Real>
struct ColumnPair {
  const std::complex<Real>* plus;
  const std::complex<Real>* minus;
  std::int64_t length, stride;
};

/// What the longest vectors may read or write beyond a column.
constexpr std::int64_t kColumnPadding = 16;

/// Adds Σ_k c_k(q_z)·T̂_k to the four nodes (±k_x, ±k_y) for all k_y ≤ c; T̂_k comes from the Hermitian halves
/// T̂_2f = (Z(q) + Z*(−q))/2, T̂_2f+1 = (Z(q) − Z*(−q))/2i. q_z² = sphere − step²·(k_x² + k_y²), in rad²/µm².
void combine_columns(const CoefficientTable<float>& c, const ColumnPair<float>& columns, int kx,
                     double sphere, double step, DiskField<float>& field);
void combine_columns(const CoefficientTable<double>& c, const ColumnPair<double>& columns, int kx,
                     double sphere, double step, DiskField<double>& field);

}  // namespace micro
