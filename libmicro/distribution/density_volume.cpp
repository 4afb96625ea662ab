#include "distribution/density_volume.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"

namespace micro {
namespace {

using std::numbers::pi;

constexpr int kTaps = DensityVolume::kTaps;

/// Weights of kTaps nodes around u (in nodes), and the first of them: sinc times a Kaiser–Bessel window whose
/// transform ends where the oversampling leaves room, half the band on either side.
struct Stencil {
  std::int64_t first;
  std::array<double, kTaps> weight;
};

Stencil stencil(double u) {
  constexpr double kHalf = kTaps / 2.0;
  constexpr double kBeta = pi * kHalf * (1 - 1 / DensityVolume::kOversampling);
  Stencil s{static_cast<std::int64_t>(std::floor(u)) - kTaps / 2 + 1, {}};
  const double peak = std::cyl_bessel_i(0, kBeta);
  for (int t = 0; t < kTaps; ++t) {
    const double x = u - static_cast<double>(s.first + t), inside = 1 - x * x / (kHalf * kHalf);
    const double sinc = std::abs(x) < 1e-9 ? 1 : std::sin(pi * x) / (pi * x);
    s.weight[static_cast<std::size_t>(t)] =
        sinc * std::cyl_bessel_i(0, kBeta * std::sqrt(std::max(0.0, inside))) / peak;
  }
  return s;
}

void require(bool good, const char* what) {
  if (!good) throw InputError(std::string("a volume of D_K needs ") + what);
}

}  // namespace

VolumeGrid volume_grid(const VolumeExtent& extent) {
  constexpr double kSpare = kTaps / 2 + 1;
  const auto step = [](double length) { return pi / (DensityVolume::kOversampling * length); };
  // A flat patch has no speckle along q_z, but a density that grows as q_z²: as if 20/q_z high.
  const double step_z = step(std::max(extent.height, 20 / extent.q_z));
  const auto reach = [&](double q, double s) {
    return static_cast<std::int64_t>(std::floor(q / s + kSpare));
  };
  const double step_x = step(extent.side_x), step_y = step(extent.side_y);
  const auto last_z = reach(extent.q_z, step_z);
  return {step_x,
          step_y,
          step_z,
          reach(extent.q_xy, step_x),
          reach(extent.q_xy, step_y),
          -kTaps / 2,
          last_z + kTaps / 2 + 1};
}

DensityVolume::DensityVolume(const VolumeExtent& extent, std::int64_t most_bytes) : extent_(extent) {
  for (const double positive : {extent.side_x, extent.side_y, extent.q_xy, extent.q_z})
    require(std::isfinite(positive) && positive > 0, "sides and wave numbers that are positive and finite");
  require(std::isfinite(extent.height) && extent.height >= 0, "a height range that is finite");
  const double most = static_cast<double>(most_bytes);
  // In double first: numbers of nodes may overflow.
  const double nodes = (4 * extent.q_xy * extent.side_x / pi + 14) *
                       (4 * extent.q_xy * extent.side_y / pi + 14) *
                       (2 * extent.q_z * extent.height / pi + 12);
  const auto refuse = [&](double bytes) {
    throw InputError("D_K of this patch as a volume would take " + std::to_string(bytes / 1e9) +
                     " GB: its speckle is too fine for that many wave numbers, lower q_xy or q_z");
  };
  if (nodes * sizeof(float) > 2 * most) refuse(nodes * sizeof(float));
  grid_ = volume_grid(extent);
  if (bytes() > most_bytes) refuse(static_cast<double>(bytes()));
  values_.assign(static_cast<std::size_t>(grid_.size()), 0);
}

double DensityVolume::operator()(const Vec3& q) const {
  const Vec3 up = q.z() < 0 ? Vec3(-q) : q;
  constexpr double kRounding = 1 + 1e-9;
  if (!(std::abs(up.x()) <= extent_.q_xy * kRounding && std::abs(up.y()) <= extent_.q_xy * kRounding &&
        up.z() <= extent_.q_z * kRounding))
    throw InputError("the volume of D_K does not reach as far as this q");
  const Stencil x = stencil(up.x() / grid_.step_x), y = stencil(up.y() / grid_.step_y),
                z = stencil(up.z() / grid_.step_z);
  double sum = 0;
  for (int b = 0; b < kTaps; ++b)
    for (int a = 0; a < kTaps; ++a) {
      const std::size_t from = index(x.first + a, y.first + b, z.first - grid_.first_z);
      double along_z = 0;
      for (std::size_t c = 0; c < kTaps; ++c)
        along_z += z.weight[c] * static_cast<double>(values_[from + c]);
      sum += x.weight[static_cast<std::size_t>(a)] * y.weight[static_cast<std::size_t>(b)] * along_z;
    }
  return sum;
}

void DensityVolume::add(const DensityVolume& other, double weight) {
  if (!(other.grid_ == grid_)) throw InputError("volumes of different grids have no common mean");
  for (std::size_t n = 0; n < values_.size(); ++n)
    values_[n] += static_cast<float>(weight) * other.values_[n];
}

void DensityVolume::scale(double factor) {
  for (float& value : values_)
    value *= static_cast<float>(factor);
}

}  // namespace micro
