// Runs lobes of extreme parameters through evaluation, sampling and fitting and writes what comes out as a
// table.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <string>

#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "fit/fit.h"
#include "testing/ellipsoid_formula.h"
#include "testing/lobe_zoo.h"
#include "testing/step_between.h"

namespace micro {
namespace {

/// Largest relative distance of D and of G1 from the printed formulas in 50 digits, over sampled normals.
struct Distance {
  double of_d = 0, of_g1 = 0;
};
Distance from_formula(const EllipsoidParameters& parameters, const Ellipsoid& lobe) {
  Distance distance;
  for (std::uint64_t k = 0; k < 200; ++k) {
    const auto [a, b] = random_uniform(3, 0, k);
    const Vec3 m = lobe.sample({a, b});
    const auto relative = [](double got, double exact) { return exact > 0 ? std::abs(got / exact - 1) : 0; };
    distance.of_d = std::max(distance.of_d, relative(lobe.D(m), testing::printed_ellipsoid_D(parameters, m)));
    distance.of_g1 =
        std::max(distance.of_g1, relative(lobe.G1(m), testing::printed_ellipsoid_G1(parameters, m)));
  }
  return distance;
}

/// Of 10,000 samples those within the circle that holds half of the lobe, less half, in standard errors; NaN
/// if one is not a direction above the horizon.
template <typename Lobe>
double half_inside(const Lobe& lobe, double radius2) {
  constexpr int kSamples = 10000;
  int inside = 0;
  for (std::uint64_t k = 0; k < kSamples; ++k) {
    const auto [a, b] = random_uniform(4, 0, k);
    const Vec3 m = lobe.sample({a, b});
    if (!(m.z() >= 0 && std::abs(m.norm() - 1) < 1e-12)) return NAN;
    inside += lobe.frame().whiten(slope_of(m)).squaredNorm() < radius2 ? 1 : 0;
  }
  return (inside - kSamples / 2.) / std::sqrt(kSamples / 4.);
}

std::string fitted(const DiskTable& table, FitModel model, const SlopeFrame& frame) {
  const Fit found = fit(table, model);
  char text[200];
  if (found.status == FitStatus::Empty) return "empty";
  std::snprintf(text, sizeof text, "%s, %.0e%s%s", std::string(name_of(found.status)).c_str(),
                testing::step_between(frame, found.frame).cwiseAbs().maxCoeff(),
                found.undetermined.empty() ? "" : "; ", found.undetermined.c_str());
  return text;
}

}  // namespace
}  // namespace micro

int main() {
  using namespace micro;
  std::puts(
      "| lobe | α_x | α_y | θ_x, θ_y, θ_z | D | G1 | samples (ellipsoid, Beckmann) | table | ellipsoid "
      "fitted | Beckmann "
      "fitted |\n|---|---|---|---|---|---|---|---|---|---|");
  for (const testing::ZooLobe& row : testing::zoo_lobes()) {
    const EllipsoidParameters& p = row.parameters;
    const SlopeFrame frame = slope_frame(p);
    const Ellipsoid ellipsoid(frame);
    const Beckmann beckmann(frame);
    const Distance distance = from_formula(p, ellipsoid);
    std::printf("| %s | %g | %g | %.4g, %.4g, %.4g | %.0e | %.0e | %.1f, %.1f | %d², extent %g | %s | %s |\n",
                row.name.c_str(), p.alpha_x, p.alpha_y, p.theta_x, p.theta_y, p.theta_z, distance.of_d,
                distance.of_g1, half_inside(ellipsoid, 1), half_inside(beckmann, std::numbers::ln2),
                row.grid.size, row.grid.extent,
                fitted(tabulate(ellipsoid, row.grid), FitModel::EllipsoidNdf, frame).c_str(),
                fitted(tabulate(beckmann, row.grid), FitModel::BeckmannNdf, frame).c_str());
  }
}
