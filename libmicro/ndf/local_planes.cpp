#include "ndf/local_planes.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <sstream>

#include "core/error.h"
#include "core/large_pages.h"
#include "core/parallel.h"
#include "ndf/gaussian_passes.h"
#include "ndf/plane_fits.h"
#include "ndf/truncation.h"

namespace micro {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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
  const double of_s = sxx * syy / (sxx + syy);  // no more than S's least eigenvalue
  const double needed = 2 * (1 + mu2) * kLeastCondition * largest;
  return least(x.m0) * least(y.m0) >= needed && of_s >= needed;
}

/// How many points are missing in any rectangle: a summed-area table, made only if a point is missing.
class Holes {
 public:
  explicit Holes(const HeightField& surface) : missing_(missing_count(surface)) {
    if (missing_ == 0) return;
    sums_ = Grid<std::int32_t>::Zero(surface.rows() + 1, surface.cols() + 1);
    for (Eigen::Index j = 0; j < surface.rows(); ++j) {
      std::int32_t in_row = 0;
      for (Eigen::Index i = 0; i < surface.cols(); ++i) {
        in_row += is_missing(surface.z(j, i));
        sums_(j + 1, i + 1) = sums_(j, i + 1) + in_row;
      }
    }
  }
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

/// The passes and fits of one strip of columns. Its row passes are kept for the strip alone, so that the
/// column passes find them in the processor's cache.
struct FilteredStrip {
  Strip z_g, z_gx;         // heights filtered along x with g and x·g
  Strip m_g, m_gx, m_gxx;  // the mask; of no rows where no point in reach is missing
};

class LocalPlanes {
 public:
  LocalPlanes(const HeightField& surface, double sigma)
      : surface_(surface),
        sigma_(sigma),
        taps_x_(surface.dx, sigma, longest_radius(static_cast<std::size_t>(surface.cols()))),
        taps_y_(surface.dy, sigma, longest_radius(static_cast<std::size_t>(surface.rows()))),
        profile_x_(static_cast<std::size_t>(surface.cols()), taps_x_),
        profile_y_(static_cast<std::size_t>(surface.rows()), taps_y_),
        borders_fit_(borders_well_conditioned(profile_x_, profile_y_)),
        holes_(surface) {}

  SlopeField fit() {
    for (Grid<double>* slope : {&slopes_.zx, &slopes_.zy}) {
      slope->resize(rows(), cols());
      // A strip of columns lies on a small page of its own for each row of a large scan.
      prefer_large_pages(slope->data(), sizeof(double) * static_cast<std::size_t>(slope->size()));
    }
    std::atomic<Eigen::Index> without_normal = 0;
    const std::int64_t strips = (cols() + kColumns - 1) / kColumns;
    parallel_for(strips, [&](std::int64_t strip) { without_normal += fit_strip(strip * kColumns); });
    slopes_.without_normal = without_normal;
    return std::move(slopes_);
  }

 private:
  static constexpr auto kColumns = static_cast<std::ptrdiff_t>(kStripColumns);

  std::ptrdiff_t rows() const { return surface_.rows(); }
  std::ptrdiff_t cols() const { return surface_.cols(); }
  std::ptrdiff_t radius_x() const { return static_cast<std::ptrdiff_t>(taps_x_.radius()); }
  std::ptrdiff_t radius_y() const { return static_cast<std::ptrdiff_t>(taps_y_.radius()); }

  /// Fits the columns from i0 on; returns how many present points got no normal.
  Eigen::Index fit_strip(std::ptrdiff_t i0) {
    const FilteredStrip strip = filter_rows(i0);
    Eigen::Index without = 0;
    for (std::ptrdiff_t row = 0; row < rows(); row += static_cast<std::ptrdiff_t>(kBlockRows))
      without += fit_block(strip, row, i0);
    return without;
  }

  /// Row passes: heights always; the mask only where a missing point is in reach of the strip.
  FilteredStrip filter_rows(std::ptrdiff_t i0) const {
    const auto n = static_cast<std::size_t>(rows());
    const bool masked = holes_.within(0, rows(), i0 - radius_x(), i0 + kColumns + radius_x());
    const std::size_t n_masked = masked ? n : 0;
    FilteredStrip strip{Strip(n), Strip(n), Strip(n_masked), Strip(n_masked), Strip(n_masked)};
    const std::ptrdiff_t left = i0 - radius_x(), begin = std::max<std::ptrdiff_t>(0, left),
                         end = std::min(cols(), i0 + kColumns + radius_x());
    std::vector<double> heights(static_cast<std::size_t>(kColumns + 2 * radius_x()));
    std::vector<std::size_t> missing, present;
    for (std::ptrdiff_t j = 0; j < rows(); ++j) {
      const float* z = &surface_.z(j, 0);
      for (std::ptrdiff_t i = begin; i < end; ++i)
        heights[static_cast<std::size_t>(i - left)] = is_missing(z[i]) ? 0.0 : static_cast<double>(z[i]);
      const auto row = static_cast<std::size_t>(j);
      pass_along_row(heights.data(), taps_x_, {strip.z_g.at(row), strip.z_gx.at(row)});
      if (!masked) continue;
      missing.clear();
      present.clear();
      for (std::ptrdiff_t i = begin; i < end; ++i)
        (is_missing(z[i]) ? missing : present).push_back(static_cast<std::size_t>(i - left));
      filter_mask(missing, present, i0, {strip.m_g.at(row), strip.m_gx.at(row), strip.m_gxx.at(row)});
    }
    return strip;
  }

  /// The mask's row pass: the few points that are there, or the whole row's known profile without the few
  /// that are not.
  void filter_mask(const std::vector<std::size_t>& missing, const std::vector<std::size_t>& present,
                   std::ptrdiff_t i0, double* const (&out)[3]) const {
    const bool few_missing = missing.size() < present.size();
    const std::vector<double>* const profile[] = {&profile_x_.m0, &profile_x_.m1, &profile_x_.m2};
    const std::ptrdiff_t i1 = std::min(i0 + kColumns, cols());
    for (std::size_t m = 0; m < 3; ++m) {
      std::fill_n(out[m], kStripColumns, 0.0);
      if (few_missing) std::copy(profile[m]->data() + i0, profile[m]->data() + i1, out[m]);
    }
    add_along_row(few_missing ? missing : present, few_missing ? -1 : 1, taps_x_, out);
  }

  /// Column passes and fits of kBlockRows rows of a strip; returns how many present points got no normal.
  Eigen::Index fit_block(const FilteredStrip& strip, std::ptrdiff_t j0, std::ptrdiff_t i0) {
    const std::ptrdiff_t j1 = std::min(j0 + static_cast<std::ptrdiff_t>(kBlockRows), rows());
    const std::ptrdiff_t i1 = std::min(i0 + kColumns, cols());
    const auto row = static_cast<std::size_t>(j0);
    const bool hole = holes_.within(j0 - radius_y(), j1 + radius_y(), i0 - radius_x(), i1 + radius_x());
    const bool inside =
        j0 >= radius_y() && j1 + radius_y() <= rows() && i0 >= radius_x() && i1 + radius_x() <= cols();

    BlockMoments moments;
    pass_across_rows(strip.z_gx, taps_y_, row, 0, 1, &moments.zx);
    if (inside && !hole) {
      pass_across_rows(strip.z_g, taps_y_, row, 1, 1, &moments.z[1]);
      const double x_scale = 1 / (sigma_ * profile_x_.m2[static_cast<std::size_t>(i0)] * profile_y_.m0[row]);
      const double y_scale = 1 / (sigma_ * profile_x_.m0[static_cast<std::size_t>(i0)] * profile_y_.m2[row]);
      for (std::ptrdiff_t j = j0; j < j1; ++j)
        for (std::ptrdiff_t i = i0; i < i1; ++i) {
          slopes_.zx(j, i) = moments.zx[j - j0][i - i0] * x_scale;
          slopes_.zy(j, i) = moments.z[1][j - j0][i - i0] * y_scale;
        }
      return 0;
    }
    pass_across_rows(strip.z_g, taps_y_, row, 0, 2, moments.z);

    // A border cuts the window to a rectangle: its moments are products, x and y decouple.
    if (!hole && borders_fit_) {
      for (std::ptrdiff_t j = j0; j < j1; ++j)
        for (std::ptrdiff_t i = i0; i < i1; ++i) {
          const auto r = static_cast<std::size_t>(j - j0), c = static_cast<std::size_t>(i - i0);
          const auto px = static_cast<std::size_t>(i), py = static_cast<std::size_t>(j);
          const double along = moments.zx[r][c] - moments.z[0][r][c] * profile_x_.mean[px];
          const double across = moments.z[1][r][c] - moments.z[0][r][c] * profile_y_.mean[py];
          slopes_.zx(j, i) = along * profile_x_.inverse_variance[px] / (profile_y_.m0[py] * sigma_);
          slopes_.zy(j, i) = across * profile_y_.inverse_variance[py] / (profile_x_.m0[px] * sigma_);
        }
      return 0;
    }
    if (hole) {
      pass_across_rows(strip.m_g, taps_y_, row, 0, 3, moments.m);
      pass_across_rows(strip.m_gx, taps_y_, row, 0, 2, moments.mx);
      pass_across_rows(strip.m_gxx, taps_y_, row, 0, 1, &moments.mxx);
    } else {
      for (std::ptrdiff_t j = j0; j < j1; ++j)
        for (std::ptrdiff_t i = i0; i < i1; ++i)
          set_border_moments(moments, static_cast<std::size_t>(j - j0), static_cast<std::size_t>(i - i0),
                             static_cast<std::size_t>(j), static_cast<std::size_t>(i));
    }
    return put_fits(moments, j0, j1, i0, i1);
  }

  /// Writes the slopes of a block's points [j0, j1) × [i0, i1); returns how many of those present have none.
  Eigen::Index put_fits(const BlockMoments& moments, std::ptrdiff_t j0, std::ptrdiff_t j1, std::ptrdiff_t i0,
                        std::ptrdiff_t i1) {
    const BlockFits fits = fit_planes(moments);
    const double per_sigma = 1 / sigma_;
    Eigen::Index without = 0;
    for (std::ptrdiff_t j = j0; j < j1; ++j)
      for (std::ptrdiff_t i = i0; i < i1; ++i) {
        const auto r = static_cast<std::size_t>(j - j0), c = static_cast<std::size_t>(i - i0);
        const bool there = !is_missing(surface_.z(j, i));
        const bool fitted = there && (fits.margin[r][c] > 0 || well_conditioned(moments, r, c));
        slopes_.zx(j, i) = fitted ? fits.zx[r][c] * per_sigma : kNaN;
        slopes_.zy(j, i) = fitted ? fits.zy[r][c] * per_sigma : kNaN;
        without += there && !fitted;
      }
    return without;
  }

  void set_border_moments(BlockMoments& w, std::size_t r, std::size_t c, std::size_t j, std::size_t i) const {
    const Profile &x = profile_x_, &y = profile_y_;
    w.m[0][r][c] = x.m0[i] * y.m0[j];
    w.m[1][r][c] = x.m0[i] * y.m1[j];
    w.m[2][r][c] = x.m0[i] * y.m2[j];
    w.mx[0][r][c] = x.m1[i] * y.m0[j];
    w.mx[1][r][c] = x.m1[i] * y.m1[j];
    w.mxx[r][c] = x.m2[i] * y.m0[j];
  }

  const HeightField& surface_;
  double sigma_;
  GaussianTaps taps_x_, taps_y_;
  Profile profile_x_, profile_y_;
  bool borders_fit_;
  Holes holes_;
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
