#include "ndf/local_planes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>

#include "core/error.h"
#include "core/parallel.h"
#include "ndf/gaussian_passes.h"
#include "ndf/truncation.h"

namespace micro {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Gaussian moments of a window in units of σ: of the mask (m…) and of the heights (z…).
struct Moments {
  double m, mx, my, mxx, mxy, myy;
  double z, zx, zy;
};

struct Slopes {
  double x, y;  ///< per σ; NaN if the moments don't determine a plane
};

/// A lower bound on the moment matrix's least eigenvalue. With the mean position
/// µ = (⟨x⟩, ⟨y⟩)/⟨1⟩ and the centred second moments S the matrix is L·diag(⟨1⟩, S)·Lᵀ, and ‖L⁻¹‖² ≤ 2(1 +
/// µ²).
double least_eigenvalue_bound(double m, double mu2, double determinant, double trace) {
  return trace > 0 ? std::min(m, determinant / trace) / (2 * (1 + mu2)) : 0;
}

/// Is the reciprocal condition at least kLeastCondition? The bound settles nearly all cases, the eigenvalues
/// the rest.
bool well_conditioned(const Moments& w, double mu2, double determinant, double trace) {
  if (least_eigenvalue_bound(w.m, mu2, determinant, trace) >= kLeastCondition * (w.m + w.mxx + w.myy))
    return true;
  Eigen::Matrix3d matrix;
  matrix << w.m, w.mx, w.my, w.mx, w.mxx, w.mxy, w.my, w.mxy, w.myy;
  const Eigen::Vector3d eigenvalues = matrix.selfadjointView<Eigen::Lower>().eigenvalues();
  return eigenvalues[0] >= kLeastCondition * eigenvalues[2];
}

/// Solves the 3×3 normal equations, the constant eliminated first. NaN if they are ill conditioned.
Slopes fit_plane(const Moments& w) {
  const double mu_x = w.mx / w.m, mu_y = w.my / w.m;
  const double sxx = w.mxx - mu_x * w.mx, sxy = w.mxy - mu_x * w.my, syy = w.myy - mu_y * w.my;
  const double szx = w.zx - w.z * mu_x, szy = w.zy - w.z * mu_y;
  const double determinant = sxx * syy - sxy * sxy;
  if (!well_conditioned(w, mu_x * mu_x + mu_y * mu_y, determinant, sxx + syy)) return {kNaN, kNaN};
  const double inverse = 1 / determinant;
  return {(szx * syy - szy * sxy) * inverse, (szy * sxx - szx * sxy) * inverse};
}

/// ⟨1⟩, ⟨x⟩, ⟨x²⟩ of a complete row (or column) of n points around each of its points: the border's effect
/// alone.
struct Profile {
  std::vector<double> m0, m1, m2;
  std::vector<double> mean;              ///< ⟨x⟩/⟨1⟩
  std::vector<double> inverse_variance;  ///< 1/(⟨x²⟩ − ⟨x⟩²/⟨1⟩)

  Profile(std::size_t n, const GaussianTaps& taps) : m0(n), m1(n), m2(n), mean(n), inverse_variance(n) {
    const auto last = static_cast<std::ptrdiff_t>(n) - 1, radius = static_cast<std::ptrdiff_t>(taps.radius());
    for (std::ptrdiff_t i = 0; i <= last; ++i)
      for (std::ptrdiff_t t = std::max(-radius, -i); t <= std::min(radius, last - i); ++t) {
        m0[static_cast<std::size_t>(i)] += taps.moment(0)[t + radius];
        m1[static_cast<std::size_t>(i)] += taps.moment(1)[t + radius];
        m2[static_cast<std::size_t>(i)] += taps.moment(2)[t + radius];
      }
    for (std::size_t i = 0; i < n; ++i) {
      mean[i] = m1[i] / m0[i];
      inverse_variance[i] = 1 / (m2[i] - mean[i] * m1[i]);
    }
  }
};

/// Are all fits of a surface without holes well conditioned? Bounds each factor by its worst value along the
/// profile.
bool borders_well_conditioned(const Profile& x, const Profile& y) {
  const auto least = [](const std::vector<double>& v) { return *std::min_element(v.begin(), v.end()); };
  const auto most = [](const std::vector<double>& v) { return *std::max_element(v.begin(), v.end()); };
  const double mu2 = std::pow(std::max(-least(x.mean), most(x.mean)), 2) +
                     std::pow(std::max(-least(y.mean), most(y.mean)), 2);
  const double sxx = least(y.m0) / most(x.inverse_variance), syy = least(x.m0) / most(y.inverse_variance);
  const double largest = most(x.m0) * most(y.m0) + most(x.m2) * most(y.m0) + most(x.m0) * most(y.m2);
  return least_eigenvalue_bound(least(x.m0) * least(y.m0), mu2, sxx * syy, sxx + syy) >=
         kLeastCondition * largest;
}

/// How many points are missing in any rectangle: a summed-area table, made only if a point is missing.
class Holes {
 public:
  explicit Holes(const HeightField& surface) : missing_(missing_count(surface)) {
    if (missing_ == 0) return;
    sums_ = Grid<std::int32_t>::Zero(surface.rows() + 1, surface.cols() + 1);
    for (Eigen::Index j = 0; j < surface.rows(); ++j)
      for (Eigen::Index i = 0; i < surface.cols(); ++i)
        sums_(j + 1, i + 1) =
            sums_(j, i + 1) + sums_(j + 1, i) - sums_(j, i) + (is_missing(surface.z(j, i)) ? 1 : 0);
  }
  bool any() const { return missing_ > 0; }
  /// Is a point missing in rows [j0, j1) × columns [i0, i1), clipped to the surface?
  bool within(std::ptrdiff_t j0, std::ptrdiff_t j1, std::ptrdiff_t i0, std::ptrdiff_t i1) const {
    if (missing_ == 0) return false;
    const auto row = [&](std::ptrdiff_t j) { return std::clamp<std::ptrdiff_t>(j, 0, sums_.rows() - 1); };
    const auto col = [&](std::ptrdiff_t i) { return std::clamp<std::ptrdiff_t>(i, 0, sums_.cols() - 1); };
    return sums_(row(j1), col(i1)) - sums_(row(j0), col(i1)) - sums_(row(j1), col(i0)) +
               sums_(row(j0), col(i0)) >
           0;
  }

 private:
  Eigen::Index missing_;
  Grid<std::int32_t> sums_;
};

/// No window of n points reaches further than this. At least 1: a single point never has a complete window.
std::size_t longest_radius(std::size_t n) {
  return std::max<std::size_t>(n, 2) - 1;
}

class LocalPlanes {
 public:
  LocalPlanes(const HeightField& surface, double sigma)
      : surface_(surface),
        sigma_(sigma),
        rows_(static_cast<std::size_t>(surface.rows())),
        cols_(static_cast<std::size_t>(surface.cols())),
        taps_x_(surface.dx, sigma, longest_radius(cols_)),
        taps_y_(surface.dy, sigma, longest_radius(rows_)),
        profile_x_(cols_, taps_x_),
        profile_y_(rows_, taps_y_),
        borders_fit_(borders_well_conditioned(profile_x_, profile_y_)),
        holes_(surface),
        z_g_(rows_, cols_),
        z_gx_(rows_, cols_) {
    if (!holes_.any()) return;
    m_g_.emplace(rows_, cols_);
    m_gx_.emplace(rows_, cols_);
    m_gxx_.emplace(rows_, cols_);
  }

  SlopeField fit() {
    parallel_blocks(rows(), 16, [&](std::int64_t begin, std::int64_t end) { filter_rows(begin, end); });
    slopes_.zx.resize(surface_.rows(), surface_.cols());
    slopes_.zy.resize(surface_.rows(), surface_.cols());
    std::atomic<Eigen::Index> without_normal = 0;
    parallel_for(static_cast<std::int64_t>(z_g_.tiles()), [&](std::int64_t tile) {
      Eigen::Index without = 0;
      for (std::size_t row = 0; row < rows_; row += kBlockRows)
        without += fit_block(static_cast<std::size_t>(tile), row);
      without_normal += without;
    });
    slopes_.without_normal = without_normal;
    return std::move(slopes_);
  }

 private:
  std::ptrdiff_t rows() const { return surface_.rows(); }
  std::ptrdiff_t cols() const { return surface_.cols(); }
  std::ptrdiff_t radius_x() const { return static_cast<std::ptrdiff_t>(taps_x_.radius()); }
  std::ptrdiff_t radius_y() const { return static_cast<std::ptrdiff_t>(taps_y_.radius()); }

  /// Row passes: heights always; the mask only where a missing point is in reach, its known profile
  /// elsewhere.
  void filter_rows(std::int64_t begin, std::int64_t end) {
    std::vector<double> heights = padded_row(cols_, taps_x_.radius());
    std::vector<double> mask = holes_.any() ? heights : std::vector<double>();
    TiledRows* const z_out[] = {&z_g_, &z_gx_};
    for (std::int64_t j = begin; j < end; ++j) {
      const auto row = static_cast<std::size_t>(j);
      const float* z = &surface_.z(j, 0);
      double* centre = heights.data() + taps_x_.radius();
      for (std::size_t i = 0; i < cols_; ++i)
        centre[i] = is_missing(z[i]) ? 0.0 : static_cast<double>(z[i]);
      pass_along_row(heights.data(), taps_x_, row, 0, z_g_.tiles(), 2, z_out);
      if (!holes_.any()) continue;
      double* present = mask.data() + taps_x_.radius();
      for (std::size_t i = 0; i < cols_; ++i)
        present[i] = is_missing(z[i]) ? 0.0 : 1.0;
      TiledRows* const m_out[] = {&*m_g_, &*m_gx_, &*m_gxx_};
      for (std::size_t tile = 0; tile < z_g_.tiles(); ++tile) {
        const auto i0 = static_cast<std::ptrdiff_t>(tile * kTileColumns);
        const auto i1 = i0 + static_cast<std::ptrdiff_t>(kTileColumns);
        if (holes_.within(j, j + 1, i0 - radius_x(), i1 + radius_x())) {
          pass_along_row(mask.data(), taps_x_, row, tile, tile + 1, 3, m_out);
        } else {
          const std::size_t first = tile * kTileColumns, last = std::min(first + kTileColumns, cols_);
          const auto copy = [&](const std::vector<double>& profile, TiledRows& out) {
            std::copy(profile.begin() + static_cast<std::ptrdiff_t>(first),
                      profile.begin() + static_cast<std::ptrdiff_t>(last), out.at(tile, row));
          };
          copy(profile_x_.m0, *m_g_);
          copy(profile_x_.m1, *m_gx_);
          copy(profile_x_.m2, *m_gxx_);
        }
      }
    }
  }

  /// Column passes and fits of kBlockRows rows of one tile; returns how many present points got no normal.
  Eigen::Index fit_block(std::size_t tile, std::size_t row) {
    const auto j0 = static_cast<std::ptrdiff_t>(row), i0 = static_cast<std::ptrdiff_t>(tile * kTileColumns);
    const std::ptrdiff_t j1 = std::min(j0 + static_cast<std::ptrdiff_t>(kBlockRows), rows());
    const std::ptrdiff_t i1 = std::min(i0 + static_cast<std::ptrdiff_t>(kTileColumns), cols());
    const bool hole = holes_.within(j0 - radius_y(), j1 + radius_y(), i0 - radius_x(), i1 + radius_x());
    const bool inside =
        j0 >= radius_y() && j1 + radius_y() <= rows() && i0 >= radius_x() && i1 + radius_x() <= cols();

    TileBlock z[2], zx;  // z[0] = ⟨z⟩, z[1] = ⟨yz⟩
    pass_across_rows(z_gx_, taps_y_, tile, row, 0, 1, &zx);
    if (inside && !hole) {
      pass_across_rows(z_g_, taps_y_, tile, row, 1, 1, &z[1]);
      const double x_scale = 1 / (sigma_ * profile_x_.m2[static_cast<std::size_t>(i0)] * profile_y_.m0[row]);
      const double y_scale = 1 / (sigma_ * profile_x_.m0[static_cast<std::size_t>(i0)] * profile_y_.m2[row]);
      for (std::ptrdiff_t j = j0; j < j1; ++j)
        for (std::ptrdiff_t i = i0; i < i1; ++i) {
          slopes_.zx(j, i) = zx[j - j0][i - i0] * x_scale;
          slopes_.zy(j, i) = z[1][j - j0][i - i0] * y_scale;
        }
      return 0;
    }
    pass_across_rows(z_g_, taps_y_, tile, row, 0, 2, z);

    TileBlock m[3], mx[2], mxx;  // ⟨1⟩, ⟨y⟩, ⟨y²⟩; ⟨x⟩, ⟨xy⟩; ⟨x²⟩
    if (hole) {
      pass_across_rows(*m_g_, taps_y_, tile, row, 0, 3, m);
      pass_across_rows(*m_gx_, taps_y_, tile, row, 0, 2, mx);
      pass_across_rows(*m_gxx_, taps_y_, tile, row, 0, 1, &mxx);
    }
    // A border cuts the window to a rectangle: its moments are products, x and y decouple.
    if (!hole && borders_fit_) {
      for (std::ptrdiff_t j = j0; j < j1; ++j)
        for (std::ptrdiff_t i = i0; i < i1; ++i) {
          const auto r = static_cast<std::size_t>(j - j0), c = static_cast<std::size_t>(i - i0);
          const auto px = static_cast<std::size_t>(i), py = static_cast<std::size_t>(j);
          const double along = zx[r][c] - z[0][r][c] * profile_x_.mean[px];
          const double across = z[1][r][c] - z[0][r][c] * profile_y_.mean[py];
          slopes_.zx(j, i) = along * profile_x_.inverse_variance[px] / (profile_y_.m0[py] * sigma_);
          slopes_.zy(j, i) = across * profile_y_.inverse_variance[py] / (profile_x_.m0[px] * sigma_);
        }
      return 0;
    }
    Eigen::Index without = 0;
    for (std::ptrdiff_t j = j0; j < j1; ++j)
      for (std::ptrdiff_t i = i0; i < i1; ++i) {
        if (is_missing(surface_.z(j, i))) {
          slopes_.zx(j, i) = slopes_.zy(j, i) = kNaN;
          continue;
        }
        const auto r = static_cast<std::size_t>(j - j0), c = static_cast<std::size_t>(i - i0);
        Moments w =
            hole ? Moments{m[0][r][c], mx[0][r][c], m[1][r][c], mxx[r][c], mx[1][r][c], m[2][r][c], 0, 0, 0}
                 : border_moments(static_cast<std::size_t>(j), static_cast<std::size_t>(i));
        w.z = z[0][r][c];
        w.zx = zx[r][c];
        w.zy = z[1][r][c];
        const Slopes slopes = fit_plane(w);
        slopes_.zx(j, i) = slopes.x / sigma_;
        slopes_.zy(j, i) = slopes.y / sigma_;
        if (std::isnan(slopes.x)) ++without;
      }
    return without;
  }

  Moments border_moments(std::size_t j, std::size_t i) const {
    const Profile &x = profile_x_, &y = profile_y_;
    return {x.m0[i] * y.m0[j],
            x.m1[i] * y.m0[j],
            x.m0[i] * y.m1[j],
            x.m2[i] * y.m0[j],
            x.m1[i] * y.m1[j],
            x.m0[i] * y.m2[j],
            0,
            0,
            0};
  }

  const HeightField& surface_;
  double sigma_;
  std::size_t rows_, cols_;
  GaussianTaps taps_x_, taps_y_;
  Profile profile_x_, profile_y_;
  bool borders_fit_;
  Holes holes_;
  TiledRows z_g_, z_gx_;                         // heights filtered along x with g and x·g
  std::optional<TiledRows> m_g_, m_gx_, m_gxx_;  // the mask with g, x·g and x²·g
  SlopeField slopes_;
};

/// Largest absolute value; NaN count for nothing.
double largest(const Grid<double>& values) {
  return std::max(0., values.abs().maxCoeff<Eigen::PropagateNumbers>());
}

}  // namespace

void require_resolved(double sigma, const HeightField& surface) {
  const double pitch = std::max(surface.dx, surface.dy);
  if (sigma >= pitch / 2 && std::isfinite(sigma)) return;
  std::ostringstream message;
  message << "the filter's sigma of " << sigma << " µm is below half the pitch of " << pitch << " µm";
  throw InputError(message.str());
}

SlopeField local_planes(const HeightField& surface, double sigma) {
  require_resolved(sigma, surface);
  if (surface.z.size() == 0) return {};
  SlopeField slopes = LocalPlanes(surface, sigma).fit();
  slopes.truncation_error =
      slope_truncation_bound(surface, sigma, {.zx = largest(slopes.zx), .zy = largest(slopes.zy)});
  return slopes;
}

}  // namespace micro
