#include "kirchhoff/kirchhoff_volume.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "kirchhoff/disk_geometry.h"
#include "kirchhoff/kirchhoff.h"
#include "kirchhoff/spectral.h"
#include "kirchhoff/term_spectra.h"

namespace micro {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

struct Patch {
  double side_x, side_y, height;
};

Patch patch_of(const HeightField& surface, const HeightHistogram& heights) {
  return {static_cast<double>(surface.cols() - 1) * surface.dx,
          static_cast<double>(surface.rows() - 1) * surface.dy, heights.high - heights.low};
}

/// The axis whose wave numbers are the volume's own: points as close as gridding asks, a transform as long as
/// makes the step.
SpectrumAxis make_axis(double side, double step, std::int64_t reach, int gridding_width) {
  constexpr double kGriddingOversampling = 1.25;
  const double q_high = step * static_cast<double>(reach);
  const std::int64_t length = fast_fft_size(
      static_cast<std::int64_t>(std::ceil(2 * kGriddingOversampling * q_high / step)) + 4 * gridding_width);
  const double pitch = 2 * pi / (step * static_cast<double>(length)), half = gridding_width / 2.0;
  return {.side = side,
          .pitch = pitch,
          .begin = static_cast<std::int64_t>(std::ceil(-half)),
          .end = static_cast<std::int64_t>(std::floor(side / pitch + half)) + 1,
          .centre = static_cast<std::int64_t>(std::floor(side / pitch / 2)),
          .length = length,
          .step = step,
          .reach = reach,
          .gridding = GriddingKernel(gridding_width, kGriddingOversampling, pitch),
          .interpolation_width = 0,
          .oversampling = 2};
}

/// ∫e^{−iqx}dx over the side, phases counted as the axis's transforms count them.
Complex plate_spectrum(const SpectrumAxis& axis, double q) {
  const double half = q * axis.side / 2;
  const double middle = axis.side / 2 - axis.pitch * static_cast<double>(axis.centre);
  return axis.side * (std::abs(half) < 1e-8 ? 1 : std::sin(half) / half) * std::polar(1.0, -q * middle);
}

/// Terms, one row, as complex numbers.
Eigen::VectorXcd terms_of(const float* re, const float* im, Eigen::Index terms) {
  Eigen::VectorXcd values(terms);
  for (Eigen::Index k = 0; k < terms; ++k)
    values[k] = Complex(static_cast<double>(re[k]), static_cast<double>(im[k]));
  return values;
}

}  // namespace

VolumeExtent kirchhoff_extent(const HeightField& surface, double q_xy, double q_z) {
  const Patch patch = patch_of(surface, height_histogram(surface));
  return {patch.side_x, patch.side_y, patch.height, q_xy, q_z};
}

void fill_with_kirchhoff(const HeightField& surface, double tol, DensityVolume& volume) {
  constexpr std::int64_t kMostBytes = std::int64_t{1} << 31;
  const double area = kirchhoff_area(surface);
  const VolumeGrid& grid = volume.grid();
  const HeightHistogram heights = height_histogram(surface);
  const Patch patch = patch_of(surface, heights);
  const VolumeExtent& extent = volume.extent();
  constexpr double kRounding = 1 + 1e-9;
  if (patch.side_x > extent.side_x * kRounding || patch.side_y > extent.side_y * kRounding ||
      patch.height > extent.height * kRounding)
    throw InputError("the patch is larger than those that the volume of D_K resolves the speckle of");
  const std::int64_t last_z = grid.first_z + grid.count_z - 1;
  const WaveRange q = {0, static_cast<double>(last_z) * grid.step_z};
  const double q_x = grid.step_x * static_cast<double>(grid.reach_x),
               q_y = grid.step_y * static_cast<double>(grid.reach_y);
  const double radius = std::hypot(q_x, q_y, q.high);
  const DiskGrid outline = {3, std::max(q_x, q_y) / radius};
  const SpectralChoice choice = choose_spectral(surface, outline, 4 * pi / radius, tol);
  QuadratureLattice all(surface, choice.subdivision, {}, choice.steepest, choice.highest);
  const SpectrumAxis x = make_axis(patch.side_x, grid.step_x, grid.reach_x, choice.kernel_width),
                     y = make_axis(patch.side_y, grid.step_y, grid.reach_y, choice.kernel_width);
  const double tolerance = choice.basis_tolerance * std::min(1 / radius, std::sqrt(surface.dx * surface.dy));
  const HeightBasis basis(heights, 0, q, tolerance);
  const bool complete = all.complete();
  const LeftOut left_out(all, facet_phases(radius, outline, choice.basis_tolerance));
  check_work(spectra_work(surface, choice, x, y, left_out.points(), basis.terms() + (complete ? 0 : 1)),
             static_cast<double>(grid.size()), surface, 4 * pi / radius);
  const NestedTerms terms(basis, q, tolerance);
  const SurfaceQuadrature quadrature(std::move(all), left_out);
  const TermBatch batch = {0, terms.terms(), !complete};
  const std::int64_t spectra_bytes =
      std::int64_t{std::max(batch.terms(), 1)} * TermSpectra<float>::bytes_per_term(x, y);
  if (spectra_bytes > kMostBytes)
    throw InputError("the spectra of this patch would take " +
                     std::to_string(static_cast<double>(spectra_bytes) / 1e9) +
                     " GB for a volume of D_K: lower q_xy or q_z");

  // [q_z, terms] c_k and, first, the factor on I[1].
  const auto nz = static_cast<Eigen::Index>(last_z + 1);
  const Eigen::Index count = batch.terms(), skipped = complete ? 0 : 1;
  Eigen::MatrixXcd c(nz, count);
  c.rightCols(batch.count) = basis.terms() > 0
                                 ? Eigen::MatrixXcd(terms.coefficients(static_cast<int>(nz), 0, batch.count))
                                 : Eigen::MatrixXcd(nz, 0);
  for (Eigen::Index k = 0; k < nz && skipped > 0; ++k)
    c(k, 0) = grid.step_z * static_cast<double>(k);

  FftVector<std::complex<float>> memory;
  const TermSpectra<float> spectra(quadrature, heights, terms, basis.phase_reach(), batch, x, y, memory);
  const double to_density = kirchhoff_density(1, area);
  parallel_blocks(grid.cols(), 8, [&](std::int64_t begin, std::int64_t end) {
    TermColumns<float> columns;
    spectra.columns(begin - grid.reach_x, end - begin, columns);
    for (std::int64_t i = begin - grid.reach_x; i < end - grid.reach_x; ++i)
      for (std::int64_t j = -grid.reach_y; j <= grid.reach_y; ++j) {
        const double qx = grid.step_x * static_cast<double>(i), qy = grid.step_y * static_cast<double>(j);
        const float* at = columns.at(i, j + grid.reach_y);
        const int padded = columns.padded;
        Eigen::VectorXcd images = terms_of(at, at + padded, count);
        const Eigen::VectorXcd rims = terms_of(at + 2 * padded, at + 3 * padded, count);
        Complex whole = complete ? plate_spectrum(x, qx) * plate_spectrum(y, qy) : Complex(0);
        const double gridding = x.gridding.spectrum(qx) * y.gridding.spectrum(qy);
        const Eigen::VectorXcd along_rims = c * rims;
        if (!complete) {
          whole = images[0] / gridding;
          images[0] = 0;
        }
        const Eigen::VectorXcd along_images = c * images;
        for (Eigen::Index k = 0; k < nz; ++k) {
          const double qz = grid.step_z * static_cast<double>(k);
          const double squared = qx * qx + qy * qy + qz * qz;
          const Complex field = qz * whole + (squared * along_images[k] + along_rims[k]) / gridding;
          volume.at(i, j, k - grid.first_z) = static_cast<float>(to_density * std::norm(field));
        }
      }
  });
  // D(−q) = D(q).
  for (std::int64_t j = -grid.reach_y; j <= grid.reach_y; ++j)
    for (std::int64_t i = -grid.reach_x; i <= grid.reach_x; ++i)
      for (std::int64_t k = grid.first_z; k < 0; ++k)
        volume.at(i, j, k - grid.first_z) = volume.at(-i, -j, -k - grid.first_z);
}

DensityVolume kirchhoff_volume(const HeightField& surface, double q_xy, double q_z, double tol) {
  DensityVolume volume(kirchhoff_extent(surface, q_xy, q_z));
  fill_with_kirchhoff(surface, tol, volume);
  return volume;
}

}  // namespace micro
