#include "error_vs_time/fit_curves.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/estimate.h"
#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/directions.h"
#include "distribution/ellipsoid.h"
#include "distribution/scatter.h"
#include "distribution/tabulate.h"
#include "distribution/tabulated.h"
#include "fit/fit.h"

namespace micro::bench {
namespace {

using Report = std::function<void(const CurvePoint&)>;

struct NamedLobe {
  std::string name;
  EllipsoidParameters parameters;
};

const std::vector<NamedLobe>& lobes() {
  static const std::vector<NamedLobe> all = {{"round lobe", {0.2, 0.2, 0, 0, 0}},
                                             {"needle", {0.3, 0.03, 0, 0, 0.4}},
                                             {"skewed lobe", {0.2, 0.1, 0.6, 0.3, 0.5}}};
  return all;
}

/// The largest part of a step from one frame to the other, in widths.
double distance(const SlopeFrame& from, const SlopeFrame& to) {
  const Vec2 t = from.whiten(to.centre);
  return std::max({std::abs(t.x()), std::abs(t.y()), std::abs(to.l11 / from.l11 - 1),
                   std::abs(to.l22 / from.l22 - 1), std::abs(to.l21 - from.l21) / from.l22});
}

/// Seconds of one call, the fastest of three.
template <typename Call>
double seconds_of(Call&& call) {
  double fastest = INFINITY;
  for (int k = 0; k < 3; ++k) {
    const Stopwatch watch;
    call();
    fastest = std::min(fastest, watch.seconds());
  }
  return fastest;
}

void report_fit(const NamedLobe& lobe, const std::string& estimator, double asked, const DiskTable& table,
                const Report& report) {
  Fit found;
  const double seconds = seconds_of([&] { found = fit(table, FitModel::EllipsoidNdf); });
  const double error = distance(slope_frame(lobe.parameters), found.frame);
  report(
      {.part = "fit",
       .surface = lobe.name,
       .estimator = estimator,
       .asked = asked,
       .error = error,
       .error_core_free = error,
       .seconds = seconds,
       .reached = found.status == FitStatus::Converged ? CurvePoint::Reached::Yes : CurvePoint::Reached::No});
}

/// Means over bins, by 8 × 8 points in each.
DiskTable binned(const Ellipsoid& lobe, const DiskGrid& grid) {
  constexpr int kParts = 8;
  DiskTable table = make_disk_table(grid);
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      for (int k = 0; k < kParts * kParts; ++k) {
        const double x = grid.coordinate(i) + ((k % kParts + 0.5) / kParts - 0.5) * grid.spacing(),
                     y = grid.coordinate(j) + ((k / kParts + 0.5) / kParts - 0.5) * grid.spacing();
        if (x * x + y * y < 1)
          table.density(j, i) += lobe.D({x, y, std::sqrt(1 - x * x - y * y)}) / (kParts * kParts);
      }
  return table;
}

DiskTable noisy(DiskTable table, double noise) {
  const double peak = table.density.maxCoeff();
  for (Eigen::Index k = 0; k < table.density.size(); ++k)
    table.density.data()[k] += noise * peak * random_normal(1, 0, static_cast<std::uint64_t>(k))[0];
  return table;
}

/// A histogram of n normals drawn from the lobe.
DiskTable counted(const Ellipsoid& lobe, const DiskGrid& grid, std::int64_t n) {
  DiskTable table = make_disk_table(grid);
  const double share = 1 / (static_cast<double>(n) * grid.spacing() * grid.spacing());
  for (std::int64_t k = 0; k < n; ++k) {
    const auto [a, b] = random_uniform(2, 0, static_cast<std::uint64_t>(k));
    const Vec3 m = lobe.sample({a, b});
    table.density(std::lrint(m.y() / grid.spacing() + grid.centre()),
                  std::lrint(m.x() / grid.spacing() + grid.centre())) += share;
  }
  return table;
}

/// The course of the fit itself: the start, then undamped steps on the whole table.
void report_steps(const NamedLobe& lobe, const Report& report) {
  const DiskTable table = tabulate(Ellipsoid(slope_frame(lobe.parameters)), {513, 1});
  const Stopwatch watch;
  TableEquations equations(table);
  SlopeFrame frame = slope_scatter(core_nodes(table, 16384), table.grid);
  for (int step = 0; step <= 8; ++step) {
    const double error = distance(slope_frame(lobe.parameters), frame);
    report({.part = "fit",
            .surface = lobe.name,
            .estimator = "steps",
            .asked = static_cast<double>(step),
            .error = error,
            .error_core_free = error,
            .seconds = watch.seconds()});
    const NormalEquations sums = equations(frame, FitModel::EllipsoidNdf, Weighting::SolidAngle);
    frame = moved(frame, sums.gram.ldlt().solve(sums.gradient));
  }
}

void report_tabulated(const NamedLobe& named, const Report& report) {
  const Ellipsoid model(slope_frame(named.parameters));
  const std::vector<Vec3> directions = spread_directions(2000, 0.999);
  for (const int size : {33, 65, 129, 257, 513, 1025}) {
    const DiskTable table = tabulate(model, {size, 1});
    const Stopwatch masking_watch;
    const Tabulated tabulated(table);
    double squares = 0;
    for (const Vec3& u : directions)
      squares += std::pow(tabulated.G1(u) - model.G1(u), 2);
    const double masking = masking_watch.seconds(),
                 masking_error = std::sqrt(squares / static_cast<double>(directions.size()));
    report({.part = "masking",
            .surface = named.name,
            .estimator = "table",
            .asked = static_cast<double>(size),
            .error = masking_error,
            .error_core_free = masking_error,
            .seconds = masking});
    constexpr int kSamples = 100000;
    const Vec3 u = Vec3(0.6, -0.2, 0.5).normalized();
    const Stopwatch sampling_watch;
    double difference = 0, whole = 0;
    for (std::uint64_t k = 0; k < kSamples; ++k) {
      const auto [a, b] = random_uniform(3, 0, k);
      const Vec3 m = tabulated.sample_visible(u, {a, b});
      const double pdf = tabulated.pdf_visible(u, m), exact = model.pdf_visible(u, m);
      difference += (pdf - exact) * (pdf - exact) / pdf;  // ∫(p − p*)²dω
      whole += exact * exact / pdf;
    }
    const double error = std::sqrt(difference / whole);
    report({.part = "sampling",
            .surface = named.name,
            .estimator = "table",
            .asked = static_cast<double>(size),
            .error = error,
            .error_core_free = error,
            .seconds = sampling_watch.seconds()});
  }
}

}  // namespace

void fit_curves(const Report& report) {
  for (const NamedLobe& lobe : lobes()) {
    const Ellipsoid model(slope_frame(lobe.parameters));
    for (const int size : {17, 33, 65, 129, 257, 513, 1025}) {
      report_fit(lobe, "size", size, tabulate(model, {size, 1}), report);
      report_fit(lobe, "histogram", size, binned(model, {size, 1}), report);
    }
    const DiskTable exact = tabulate(model, {129, 1});
    for (const double noise : {1e-5, 1e-4, 1e-3, 1e-2, 1e-1})
      report_fit(lobe, "noise", noise, noisy(exact, noise), report);
    for (const std::int64_t n : {1000, 10000, 100000, 1000000})
      report_fit(lobe, "counts", static_cast<double>(n), counted(model, {129, 1}, n), report);
    report_steps(lobe, report);
    report_tabulated(lobe, report);
  }
}

}  // namespace micro::bench
