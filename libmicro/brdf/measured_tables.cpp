#include "brdf/measured_tables.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "brdf/bilinear_warp.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;

double at_node(std::size_t k, std::size_t nodes) {
  return static_cast<double>(k) / static_cast<double>(nodes - 1);
}

/// The direction at (u_θ, u_φ) of the unit square, and the solid angle of a unit of it.
Vec3 direction(const Vec2& u) {
  const double theta = u.x() * u.x() * kPi / 2, phi = (2 * u.y() - 1) * kPi;
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

double solid_angle(double u_theta) {
  return 2 * kPi * kPi * u_theta * std::sin(u_theta * u_theta * kPi / 2);
}

Vec3 turned(const Vec3& v, double phi) {
  return {v.x() * std::cos(phi) - v.y() * std::sin(phi), v.x() * std::sin(phi) + v.y() * std::cos(phi),
          v.z()};
}

/// Bilinear values on the unit square of normals, x the column.
struct Square {
  std::size_t rows, cols;
  std::vector<float> values;

  double operator()(const Vec2& u) const {
    const double x = std::clamp(u.x(), 0., 1.) * static_cast<double>(cols - 1),
                 y = std::clamp(u.y(), 0., 1.) * static_cast<double>(rows - 1);
    const std::size_t col = std::min(static_cast<std::size_t>(x), cols - 2),
                      row = std::min(static_cast<std::size_t>(y), rows - 2);
    const double a = x - static_cast<double>(col), b = y - static_cast<double>(row);
    const float* v = &values[row * cols + col];
    return (1 - b) * ((1 - a) * v[0] + a * v[1]) + b * ((1 - a) * v[cols] + a * v[cols + 1]);
  }
};

double mean_f(const AnyBrdf& model, const Vec3& wi, const Vec3& wo, const std::vector<double>& lambda_um) {
  double sum = 0;
  for (const double lambda : lambda_um)
    sum += model.f(wi, wo, lambda);
  return sum / static_cast<double>(lambda_um.size());
}

void check_finite(double value) {
  if (!std::isfinite(value)) throw InputError("the model is infinite or no number in some directions");
}

/// A normal and how much of the surface has it: ndf·dm.
struct Facet {
  Vec3 m;
  double share;
};

/// The normals of a square at the middles of a grid twice as fine, and fine in φ where the square is not.
std::vector<Facet> facets_of(const Square& ndf) {
  constexpr std::size_t kFiner = 2, kFewestTurns = 128;
  const std::size_t rows = std::max(kFiner * (ndf.rows - 1), kFewestTurns), cols = kFiner * (ndf.cols - 1);
  std::vector<Facet> facets;
  facets.reserve(rows * cols);
  for (std::size_t j = 0; j < rows; ++j)
    for (std::size_t i = 0; i < cols; ++i) {
      const Vec2 u((static_cast<double>(i) + 0.5) / static_cast<double>(cols),
                   (static_cast<double>(j) + 0.5) / static_cast<double>(rows));
      facets.push_back({direction(u), ndf(u) * solid_angle(u.x()) / static_cast<double>(rows * cols)});
    }
  return facets;
}

/// What retroreflection says of the normals [Dupuy18 §4.1], with a floor that leaves no direction out.
Square normals_of(const AnyBrdf& model, const std::vector<double>& lambda_um, const MeasuredGrid& grid) {
  constexpr double kLeastCosine = 1e-3, kFloor = 1e-3;  // of the light, spread over all normals
  Square ndf{grid.ndf_phi, grid.ndf_theta, std::vector<float>(grid.ndf_phi * grid.ndf_theta)};
  parallel_for(static_cast<std::int64_t>(ndf.rows), [&](std::int64_t row) {
    for (std::size_t col = 0; col < ndf.cols; ++col) {
      Vec3 m = direction({at_node(col, ndf.cols), at_node(static_cast<std::size_t>(row), ndf.rows)});
      m.z() = std::max(m.z(), kLeastCosine);
      m.normalize();
      const double value = 4 * mean_f(model, m, m, lambda_um) * m.z() * m.z();
      check_finite(value);
      ndf.values[static_cast<std::size_t>(row) * ndf.cols + col] = static_cast<float>(std::max(value, 0.));
    }
  });
  double mass = 0;
  for (const Facet& facet : facets_of(ndf))
    mass += facet.share * facet.m.z();
  if (!(mass > 0)) throw InputError("the model is dark wherever light goes back to where it came from");
  for (float& value : ndf.values)
    value = static_cast<float>((1 - kFloor) * value / mass + kFloor / kPi);
  return ndf;
}

/// ∫ ndf·max(0, m·w) dm for directions w.
Square projected_area(const Square& ndf, std::size_t rows, std::size_t cols) {
  const std::vector<Facet> facets = facets_of(ndf);
  Square sigma{rows, cols, std::vector<float>(rows * cols)};
  parallel_for(static_cast<std::int64_t>(sigma.values.size()), [&](std::int64_t k) {
    const auto node = static_cast<std::size_t>(k);
    const Vec3 w = direction({at_node(node % cols, cols), at_node(node / cols, rows)});
    double area = 0;
    for (const Facet& facet : facets)
      area += facet.share * std::max(0., facet.m.dot(w));
    sigma.values[node] = static_cast<float>(area);
  });
  return sigma;
}

/// The tables of one direction of light.
class LightDirection {
 public:
  LightDirection(double theta_i, double phi_i, double sigma)
      : wi_(std::sin(theta_i) * std::cos(phi_i), std::sin(theta_i) * std::sin(phi_i), std::cos(theta_i)),
        sigma_(sigma) {}

  void fill_visible(const Square& ndf, std::span<float> vndf, std::size_t cols) const {
    const std::size_t rows = vndf.size() / cols;
    for (std::size_t k = 0; k < vndf.size(); ++k) {
      const Vec2 u(at_node(k % cols, cols), at_node(k / cols, rows));
      vndf[k] =
          static_cast<float>(ndf(u) * std::max(0., direction(u).dot(wi_)) * solid_angle(u.x()) / sigma_);
    }
  }

  /// f·cosθ_o·4σ/ndf where the visible normals' warp takes the nodes of the unit square; gives its mean over
  /// λ.
  void fill_spectra(const AnyBrdf& model, const std::vector<double>& lambda_um, const Square& ndf,
                    const BilinearWarp& warp, std::span<float> spectra, std::span<float> luminance) const {
    const std::size_t square = luminance.size();
    const auto nodes = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(square))));
    for (std::size_t k = 0; k < square; ++k) {
      const Vec2 u = warp.sample({at_node(k % nodes, nodes), at_node(k / nodes, nodes)});
      const Vec3 wo = mirrored(wi_, direction(u));
      if (!(wo.z() > 0)) continue;
      const double scale = wo.z() * 4 * sigma_ / ndf(u);
      for (std::size_t c = 0; c < lambda_um.size(); ++c) {
        const double value = model.f(wi_, wo, lambda_um[c]) * scale;
        check_finite(value);
        spectra[c * square + k] = static_cast<float>(value);
        luminance[k] += static_cast<float>(value / static_cast<double>(lambda_um.size()));
      }
    }
    lift(luminance);
  }

 private:
  /// Leaves no part of the square undrawn.
  static void lift(std::span<float> luminance) {
    constexpr float kFloor = 1e-3f;
    double sum = 0;
    for (const float value : luminance)
      sum += static_cast<double>(value);
    const float floor =
        sum > 0 ? kFloor * static_cast<float>(sum / static_cast<double>(luminance.size())) : 1;
    for (float& value : luminance)
      value = std::max(value, floor);
  }

  Vec3 wi_;
  double sigma_;
};

}  // namespace

MeasuredGrid MeasuredGrid::isotropic() {
  return {.theta_i = 32,
          .phi_i = 1,
          .ndf_theta = 1024,
          .ndf_phi = 2,
          .sigma_theta = 33,
          .sigma_phi = 2,
          .vndf_theta = 256,
          .vndf_phi = 65,
          .samples = 64};
}

double anisotropy(const AnyBrdf& model, double lambda_um) {
  constexpr std::uint64_t kPairs = 256, kSeed = 20181;
  double most = 0;
  for (std::uint64_t k = 0; k < kPairs; ++k) {
    const auto light = random_uniform(kSeed, 0, k), draw = random_uniform(kSeed, 1, k),
               turn = random_uniform(kSeed, 2, k);
    const double sine = std::sqrt(light[0]), phi = 2 * kPi * light[1];
    const Vec3 wi(sine * std::cos(phi), sine * std::sin(phi), std::sqrt(1 - light[0]));
    const auto drawn = model.sample(wi, lambda_um, {draw[0], draw[1]});
    if (!drawn) continue;
    const double f = model.f(wi, drawn->wo, lambda_um), angle = 2 * kPi * turn[0],
                 other = model.f(turned(wi, angle), turned(drawn->wo, angle), lambda_um);
    const double larger = std::max(f, other);
    if (larger > 0) most = std::max(most, std::abs(f - other) / larger);
  }
  return most;
}

MeasuredTables measured_tables(const AnyBrdf& model, const std::vector<double>& lambda_um,
                               const MeasuredGrid& grid) {
  constexpr double kLastTheta = 0.98 * kPi / 2;
  MeasuredTables tables{.grid = grid};
  const bool isotropic = grid.phi_i == 1;
  for (std::size_t k = 0; k < grid.theta_i; ++k)
    tables.theta_i.push_back(static_cast<float>(kLastTheta * at_node(k, grid.theta_i)));
  for (std::size_t k = 0; k < grid.phi_i; ++k)
    tables.phi_i.push_back(isotropic ? 0 : static_cast<float>((2 * at_node(k, grid.phi_i) - 1) * kPi));
  for (const double lambda : lambda_um)
    tables.wavelengths.push_back(static_cast<float>(1000 * lambda));
  const Square ndf = normals_of(model, lambda_um, grid),
               sigma = projected_area(ndf, grid.sigma_phi, grid.sigma_theta);

  const std::size_t lights = grid.phi_i * grid.theta_i, normals = grid.vndf_phi * grid.vndf_theta,
                    square = grid.samples * grid.samples, colours = lambda_um.size();
  tables.vndf.resize(lights * normals);
  tables.luminance.resize(lights * square);
  tables.spectra.resize(lights * square * colours);
  parallel_for(static_cast<std::int64_t>(lights), [&](std::int64_t n) {
    const auto k = static_cast<std::size_t>(n);
    const auto theta_i = static_cast<double>(tables.theta_i[k % grid.theta_i]),
               phi_i = static_cast<double>(tables.phi_i[k / grid.theta_i]);
    const double area = sigma({std::sqrt(2 * theta_i / kPi), (phi_i + kPi) / (2 * kPi)});
    const LightDirection light(theta_i, phi_i, area);
    const std::span<float> vndf = std::span(tables.vndf).subspan(k * normals, normals);
    light.fill_visible(ndf, vndf, grid.vndf_theta);
    light.fill_spectra(model, lambda_um, ndf, BilinearWarp(vndf, grid.vndf_phi, grid.vndf_theta),
                       std::span(tables.spectra).subspan(k * square * colours, square * colours),
                       std::span(tables.luminance).subspan(k * square, square));
  });
  tables.ndf = ndf.values;
  tables.sigma = sigma.values;
  return tables;
}

}  // namespace micro
