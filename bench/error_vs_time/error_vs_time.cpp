// Error against run time of every estimator, as CSV: see curve.h for the columns and docs/accuracy.md for
// what they say. `bench/accuracy.sh` runs it and draws the curves.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "error_vs_time/brdf_curves.h"
#include "error_vs_time/fit_curves.h"
#include "error_vs_time/kirchhoff_curves.h"
#include "error_vs_time/texture_curves.h"
#include "error_vs_time/texture_recipes.h"

namespace {

using namespace micro::bench;

void say(const CurvePoint& p) {
  std::fprintf(stderr, "%s %s %s %g: error %.2e (%.2e) in %.3g s\n", p.part.c_str(), p.surface.c_str(),
               p.estimator.c_str(), p.asked, p.error, p.error_core_free, p.seconds);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Error against run time of every estimator, as CSV");
  std::filesystem::path output;
  std::vector<std::filesystem::path> scans;
  double most_seconds = 30;
  app.add_option("-o,--output", output, "CSV file to write")->required();
  app.add_option("--most-seconds", most_seconds, "A sweep ends with the first point that took longer")
      ->capture_default_str();
  std::vector<std::string> parts = {"kirchhoff", "fit", "brdf", "texture", "recipes"};
  app.add_option("--part", parts,
                 "kirchhoff, fit with masking and sampling, brdf, texture or recipes; repeatable")
      ->check(CLI::IsMember(parts))
      ->allow_extra_args(false)
      ->capture_default_str();
  app.add_option("SCAN", scans, "Real scans, beside the made surfaces");
  CLI11_PARSE(app, argc, argv);

  std::FILE* csv = std::fopen(output.c_str(), "w");
  if (csv == nullptr) {
    std::fprintf(stderr, "%s: cannot be written\n", output.c_str());
    return 1;
  }
  write_header(csv);
  const auto report = [&](const CurvePoint& point) {
    write(csv, point);
    say(point);
  };
  const auto wants = [&](const char* part) {
    return std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  if (wants("fit")) fit_curves(report);
  if (wants("brdf")) brdf_curves(report);
  if (wants("texture")) texture_curves(report);
  if (wants("recipes")) texture_recipes(report);
  if (wants("kirchhoff"))
    for (const auto& surfaces : {made_surfaces(), real_surfaces(scans)})
      for (const NamedSurface& surface : surfaces)
        kirchhoff_curves(surface, most_seconds, report);
  std::fclose(csv);
}
