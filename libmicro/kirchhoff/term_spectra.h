#pragma once

#include <cstdint>
#include <vector>

#include "core/fft.h"
#include "kirchhoff/gridding.h"
#include "kirchhoff/nested_terms.h"
#include "kirchhoff/spectral_work.h"
#include "kirchhoff/spread.h"
#include "kirchhoff/surface_quadrature.h"

namespace micro {

/// One axis of a regular grid of wave numbers about zero, j·step for j = −reach … reach, on which the spectra
/// of images of the surface are computed, and of the points that are transformed to it.
struct SpectrumAxis {
  double side;              ///< of the surface, µm
  double pitch;             ///< of the points, µm: a whole number of them fit into half a side
  std::int64_t begin, end;  ///< points within reach of the sources, counted from the surface's first edge
  std::int64_t centre;      ///< the point in the middle of the surface: phases are counted from there
  std::int64_t length;      ///< of the transform
  double step;              ///< between wave numbers, rad/µm
  std::int64_t reach;       ///< highest index
  GriddingKernel gridding;  ///< by which sources are spread over points
  int interpolation_width;  ///< wave numbers that a value between them takes, or 0
  double oversampling;      ///< transform length over points

  std::int64_t points() const { return end - begin; }
  std::int64_t count() const { return 2 * reach + 1; }
  /// The kernel by which spectra are interpolated between wave numbers: the images have been divided by its
  /// transform.
  GriddingKernel interpolation() const { return GriddingKernel(interpolation_width, oversampling, step); }
};

/// How spectra are laid out.
struct SpectrumLayout {
  double q_high;            ///< rad/µm, wave numbers of either axis up to it, and those beyond that
                            ///< interpolation reads
  int gridding_width;       ///< points (gridding.h)
  int interpolation_width;  ///< 0: values on the grid alone are wanted
  double oversampling;      ///< transform length over points, at least; > 1
};

SpectrumAxis make_spectrum_axis(double side, const SpectrumLayout& layout);

/// Terms of one pass over the surface: I[1] first where with_area is set, then terms first … first+count−1 of
/// the basis.
struct TermBatch {
  int first, count;
  bool with_area;
  int terms() const { return count + (with_area ? 1 : 0); }
};

/// Spectra of all terms of a batch on consecutive columns of the grid of wave numbers:
/// [columns, rows, 4, padded] numbers, the four being Re Â_k, Im Â_k, Re R̂_k, Im R̂_k with
///   Â_k(q_⊥) = ∫ φ_k(h) e^{−iq_⊥·x} dxdy,  R̂_k(q_⊥) = −i ∮ (q_⊥·n) φ_k(h) e^{−iq_⊥·x} dl,
/// x counted from the surface's middle, each times the transform of the gridding kernels, so that without
/// these F(q) = q_z·I[1] + Σ_k c_k(q_z)·(|q|² Â_k + R̂_k) (disk_transform.h). With I[1] among the terms, Â is
/// I[1] and R̂ is zero there.
template <typename Real>
struct TermColumns {
  std::int64_t first_column = 0, columns = 0, rows = 0;  ///< column j from first_column; row from −reach …
  int padded = 0;                                        ///< terms, a multiple of kTermLanes
  FftVector<Real> data;
  FftVector<std::complex<Real>> transforms;  ///< while they are made
  const Real* at(std::int64_t column, std::int64_t row) const {
    return data.data() + ((column - first_column) * rows + row) * 4 * padded;
  }
};

/// What the spectra of so many terms of a whole surface take.
SpectralWork spectra_work(const HeightField& surface, const SpectralChoice& choice, const SpectrumAxis& x,
                          const SpectrumAxis& y, std::int64_t steep_points, int terms);

/// The spectra Â_k and R̂_k of a surface: the rows of the images are transformed when it is made, columns when
/// they are asked for. The transforms are complex, two real images in each.
template <typename Real>
class TermSpectra {
 public:
  /// Bytes that one term takes.
  static std::int64_t bytes_per_term(const SpectrumAxis& x, const SpectrumAxis& y);

  /// `memory` holds the rows' spectra, and may serve one surface after the other.
  TermSpectra(const SurfaceQuadrature& quadrature, const HeightHistogram& heights, const NestedTerms& terms,
              double phase_reach, const TermBatch& batch, const SpectrumAxis& x, const SpectrumAxis& y,
              FftVector<std::complex<Real>>& memory);

  int padded() const { return padded_; }
  /// Complex transforms that all columns take, and have taken for the rows.
  std::int64_t transforms() const { return 2 * fields_ * (y_.points() + x_.count()); }
  /// Of memory held for the sources while their spectra were made.
  std::int64_t source_bytes() const { return source_bytes_; }

  /// Columns first … first+columns−1, all within ±reach, into `result`, whose memory is used again; callable
  /// from several threads.
  void columns(std::int64_t first, std::int64_t columns, TermColumns<Real>& result) const;

 private:
  /// Fields: two terms each, those of Â before those of R̂.
  std::complex<Real>* row_spectra(std::int64_t column, int field) const {
    return &memory_[static_cast<std::size_t>(((column + x_.reach) * 2 * fields_ + field) * padded_rows_)];
  }
  void transform_rows(const SurfaceQuadrature& quadrature, const FunctionTable<Real>& functions);
  void transform_column(std::int64_t column, std::complex<Real>* buffer) const;
  void unpack(const std::complex<Real>* plus, const std::complex<Real>* minus, std::int64_t column,
              TermColumns<Real>& result) const;

  SpectrumAxis x_, y_;
  int padded_, fields_;
  std::int64_t padded_rows_;
  ComplexFft<Real> row_fft_, column_fft_;
  FftVector<std::complex<Real>>& memory_;
  std::int64_t source_bytes_ = 0;
};

}  // namespace micro
