// Runs the zoo of extreme surfaces through the estimators and writes what comes out as a table.
#include "testing/zoo.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "core/error.h"
#include "distribution/disk_table.h"
#include "height/statistics.h"
#include "kirchhoff/spectral.h"
#include "ndf/local_planes.h"
#include "ndf/normal_counts.h"
#include "testing/exact_table.h"

namespace micro {
namespace {

constexpr double kTolerance = 1e-3;
constexpr Eigen::Index kNodes = 65;

struct Row {
  std::string name;
  double lambda_q = 0.555;
};

std::string filtered_ndf(const HeightField& surface) {
  char text[80];
  try {
    const NormalCounts counts = filtered_counts(local_planes(surface, 1), {1025, 1});
    std::snprintf(text, sizeof text, "%lld normals, ∫ = %.4f", static_cast<long long>(counts.total),
                  normalization(density(counts)));
    return text;
  } catch (const InputError& error) {
    return "refused: " + std::string(error.what());
  }
}

std::string kirchhoff(const HeightField& surface, double lambda_q) {
  char text[200];
  try {
    const DiskGrid grid{kNodes, std::min(1.0, lambda_q / (2 * std::max(surface.dx, surface.dy)))};
    const KirchhoffTable got = spectral_table(surface, grid, lambda_q, kTolerance);
    const testing::TableError error = testing::table_error(
        got.table.density, testing::exact_table(surface, grid, lambda_q), coherent_core(surface, lambda_q));
    std::snprintf(text, sizeof text, "%.2g | %.1e | %.1e | %.1e | %.2g | %s", grid.extent,
                  std::max(got.error.error(), got.error.error_core_free()), error.relative_l2,
                  error.core_free, got.cost.seconds,
                  got.reached ? "reached" : "**not reached, and said so**");
    return text;
  } catch (const InputError& error) {
    return " | | | | | refused: " + std::string(error.what());
  }
}

}  // namespace
}  // namespace micro

int main() {
  using namespace micro;
  std::vector<Row> rows;
  for (const std::string& name : testing::zoo_names())
    rows.push_back({name});
  rows.push_back({"rough", 0.01});
  rows.push_back({"rough", 1e6});
  std::puts(
      "| surface | points | λ_q (µm) | filtered NDF, σ = 1 µm | extent | D_K error said | found | found "
      "without "
      "core | seconds | tol 1e-3 |\n|---|---|---|---|---|---|---|---|---|---|");
  for (const Row& row : rows) {
    const HeightField surface = testing::zoo_surface(row.name);
    std::printf("| %s | %lld × %lld | %g | %s | %s |\n", row.name.c_str(),
                static_cast<long long>(surface.rows()), static_cast<long long>(surface.cols()), row.lambda_q,
                filtered_ndf(surface).c_str(), kirchhoff(surface, row.lambda_q).c_str());
  }
}
