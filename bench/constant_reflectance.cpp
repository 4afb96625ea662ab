// What [Dong15 Eq. 6] costs by taking the reflectance out of the Kirchhoff integral [Eq. 3].
#include <cmath>
#include <complex>
#include <cstdio>
#include <vector>

#include "core/random.h"
#include "height/gaussian_surface.h"
#include "height/statistics.h"
#include "kirchhoff/exact.h"

namespace micro {
namespace {

constexpr double kLambda = 0.5486;  // µm
constexpr int kDirections = 40;

/// Fresnel amplitude for polarisation s, cosine of incidence c, index n + ik.
std::complex<double> fresnel_s(double c, std::complex<double> index) {
  const std::complex<double> t = std::sqrt(index * index - (1 - c * c));
  return (c - t) / (c + t);
}

struct Metal {
  const char* name;
  std::complex<double> index;
};

/// √(Σ(|R(h)F|² − |F_R|²)²/Σ|F_R|⁴) over directions around the mirror's: F_R with the reflectance of each
/// facet [Dong15 Eq. 3], R(h) that of the half direction [Eq. 7].
double constant_reflectance_error(const HeightField& surface, const Metal& metal, double incidence) {
  const Vec3 wi(std::sin(incidence), 0, std::cos(incidence));
  double difference = 0, total = 0;
  for (int n = 0; n < kDirections; ++n) {
    const auto u = random_uniform(5, 5, n);
    const Vec3 flat(-0.85 * wi.x() + 0.3 * (u[0] - 0.5), 0.3 * (u[1] - 0.5), 0);
    const Vec3 wo(flat.x(), flat.y(), std::sqrt(1 - flat.squaredNorm()));
    const Vec3 q = 2 * M_PI / kLambda * (wi + wo), h = q.normalized();
    const double varying = std::norm(exact_field(
        surface, q, [&](const Vec3& m) { return fresnel_s(std::max(0.0, wi.dot(m)), metal.index); }));
    const double constant = std::norm(fresnel_s(wi.dot(h), metal.index) * exact_field(surface, q));
    difference += (constant - varying) * (constant - varying);
    total += varying * varying;
  }
  return std::sqrt(difference / total);
}

}  // namespace
}  // namespace micro

int main() {
  using namespace micro;
  // Johnson & Christy, Phys. Rev. B 6, 4370 (1972) at 2.26 eV; a dielectric for contrast.
  const std::vector<Metal> materials = {
      {"copper", {1.02, 2.59}}, {"silver", {0.06, 3.586}}, {"n = 1.5", 1.5}};
  std::puts("| rms slope | incidence | copper | silver | n = 1.5 |\n|---|---|---|---|---|");
  for (const double tau : {10.0, 3.0, 1.5, 0.75})
    for (const int degrees : {0, 45, 70}) {
      const HeightField surface =
          gaussian_surface({.rows = 192, .cols = 256}, {.rms = 0.3, .tau_x = tau, .tau_y = tau}, 1);
      std::printf("| %.2g | %d° |", std::sqrt(2.0) * 0.3 / tau, degrees);
      for (const Metal& metal : materials)
        std::printf(" %.1e |", constant_reflectance_error(surface, metal, degrees * M_PI / 180));
      std::puts("");
    }
}
