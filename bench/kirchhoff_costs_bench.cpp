// What D_K's estimators cost, as KirchhoffCosts (kirchhoff/choose.h) takes it: measures every constant on one
// thread and then holds predictions against measured seconds. Writes CSV.
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/estimate.h"
#include "core/parallel.h"
#include "height/gaussian_surface.h"
#include "height/triangles.h"
#include "kirchhoff/choose.h"
#include "kirchhoff/exact.h"
#include "kirchhoff/spectral.h"

namespace {

using namespace micro;

constexpr double kLambda = 0.555;

HeightField surface_of(Eigen::Index rows, Eigen::Index cols, double rms) {
  return gaussian_surface({rows, cols, 0.11, 0.11}, {.rms = rms, .tau_x = 3, .tau_y = 3}, 1);
}

/// The least of a few runs, s.
template <typename Body>
double seconds(int runs, Body&& body) {
  double least = INFINITY;
  for (int run = 0; run < runs; ++run) {
    const Stopwatch watch;
    body();
    least = std::min(least, watch.seconds());
  }
  return least;
}

std::vector<Vec3> directions(int n) {
  std::vector<Vec3> q;
  for (int k = 0; k < n; ++k)
    q.push_back(wave_vector(Vec3(0.2 * std::sin(k), 0.2 * std::cos(1.7 * k), 1).normalized(), kLambda));
  return q;
}

void measure_sums(KirchhoffCosts& costs) {
  const Window window{surface_of(480, 640, 0.3), {}};
  const auto triangles = static_cast<double>(triangle_count(window.surface));
  const auto few = directions(8), one = directions(1), many = directions(256);
  costs.exact_triangle = seconds(5, [&] { exact_field(window, few); }) / (8 * triangles);
  const double single = seconds(5, [&] { monte_carlo_field(window, one, {1, 7}); }) / triangles;
  const double batch = seconds(3, [&] { monte_carlo_field(window, many, {1, 7}); }) / triangles;
  costs.monte_carlo_point = (batch - single) / (6 * 255);
  costs.monte_carlo_draw = single - 6 * costs.monte_carlo_point;
}

/// One table: what the transform is made of and the seconds that it took.
struct Case {
  Eigen::Index rows, cols;
  double rms, tol;
  int size;
};

void measure_spectral(KirchhoffCosts& costs) {
  std::vector<Case> cases;
  for (const double tol : {1e-2, 1e-3, 1e-4})
    for (const int size : {65, 257, 1025})
      for (const Eigen::Index rows : {60, 240, 480})
        for (const double rms : {0.1, 0.3})
          cases.push_back({rows, rows * 4 / 3, rms, tol, size});
  // Least squares of the relative error: every row divided by its seconds.
  Eigen::MatrixXd laws(static_cast<Eigen::Index>(cases.size()), 3);
  for (std::size_t n = 0; n < cases.size(); ++n) {
    const Case& c = cases[n];
    const Window window{surface_of(c.rows, c.cols, c.rms), {}};
    const DiskGrid grid{c.size, 1};
    const SpectralChoice choice = choose_spectral(window.surface, grid, kLambda, c.tol);
    DiskMemory<float> memory;
    SpectralWork work;
    const double taken =
        seconds(3, [&] { work = transform_disk(window, grid, kLambda, choice, memory).work; });
    const auto length = static_cast<double>(work.fft_length);
    laws.row(static_cast<Eigen::Index>(n)) << work.spread,
        static_cast<double>(work.transforms) * length * std::log2(length),
        static_cast<double>(c.size) * c.size * work.terms;
    laws.row(static_cast<Eigen::Index>(n)) /= taken;
  }
  const Eigen::VectorXd fit =
      laws.colPivHouseholderQr().solve(Eigen::VectorXd::Ones(static_cast<Eigen::Index>(cases.size())));
  costs.spectral.spread = fit[0];
  costs.spectral.butterfly = fit[1];
  costs.spectral.node = fit[2];
  const HeightField surface = surface_of(480, 640, 0.3);
  costs.spectral_surface = seconds(5, [&] { choose_spectral(surface, {}, kLambda, 1e-3); }) /
                           static_cast<double>(surface.z.size());
}

void report(const char* what, double predicted, double taken) {
  std::printf("%s,%.3g,%.3g,%.2f\n", what, predicted, taken, predicted / taken);
  std::fflush(stdout);
}

}  // namespace

int main() {
  set_thread_count(1);
  KirchhoffCosts costs;
  measure_sums(costs);
  measure_spectral(costs);
  std::printf("constant,nanoseconds,in_choose_h\n");
  const KirchhoffCosts known;
  const auto constant = [](const char* name, double measured, double in_use) {
    std::printf("%s,%.3g,%.3g\n", name, 1e9 * measured, 1e9 * in_use);
  };
  constant("exact_triangle", costs.exact_triangle, known.exact_triangle);
  constant("monte_carlo_point", costs.monte_carlo_point, known.monte_carlo_point);
  constant("monte_carlo_draw", costs.monte_carlo_draw, known.monte_carlo_draw);
  constant("spectral_spread", costs.spectral.spread, known.spectral.spread);
  constant("spectral_butterfly", costs.spectral.butterfly, known.spectral.butterfly);
  constant("spectral_node", costs.spectral.node, known.spectral.node);
  constant("spectral_surface", costs.spectral_surface, known.spectral_surface);

  std::printf("request,predicted_s,taken_s,ratio\n");
  for (const double tol : {1e-2, 1e-3, 1e-4})
    for (const int size : {129, 1025})
      for (const double rms : {0.1, 0.3}) {
        const Window window{surface_of(480, 640, rms), {}};
        SpectralSolver solver({size, 1}, kLambda, tol);
        solver(window);
        const KirchhoffPrediction p =
            predict_seconds({&window, 1}, {DiskGrid{size, 1}, kLambda, tol, 1}, costs);
        char name[64];
        std::snprintf(name, sizeof name, "spectral tol %g size %d rms %g", tol, size, rms);
        report(name, p.spectral, seconds(2, [&] { solver(window); }));
      }
  for (const double tol : {3e-1, 1e-1, 1e-2}) {
    const Window window{surface_of(480, 640, 0.3), {}};
    const auto q = directions(16);
    const KirchhoffPrediction p = predict_seconds({&window, 1}, {Directions{16}, kLambda, tol, 1}, costs);
    char name[64];
    std::snprintf(name, sizeof name, "monte-carlo tol %g", tol);
    report(name, p.monte_carlo, seconds(1, [&] {
             monte_carlo_density({&window, 1}, q, {.tolerance = tol});
           }));
    report("exact", p.exact, seconds(1, [&] { exact_field(window, q); }));
  }
}
