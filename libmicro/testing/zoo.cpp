#include "testing/zoo.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "testing/cosine_surface.h"

namespace micro::testing {
namespace {

struct ZooEntry {
  std::string name;
  std::function<HeightField()> make;
};

HeightField missing_border() {
  HeightField surface = make_gaussian_surface({}, 9);
  surface.z.row(0).setConstant(kMissing);
  surface.z.row(47).setConstant(kMissing);
  surface.z.leftCols(2).setConstant(kMissing);
  surface.z.rightCols(3).setConstant(kMissing);
  return surface;
}

HeightField one_triangle() {
  HeightField surface =
      grid_surface(2, 2, 0.5, 0.3, [](auto j, auto i) { return 0.1 * static_cast<double>(i + j); });
  surface.z(1, 0) = kMissing;
  return surface;
}

/// More terms in q_z than fit into a pass, and a hole.
HeightField staircase() {
  HeightField surface = grid_surface(12, 121, 0.5, 0.5, [](auto j, auto i) {
    return 0.25 * static_cast<double>(i) + 0.05 * std::sin(static_cast<double>(i * j));
  });
  surface.z(5, 17) = kMissing;
  return surface;
}

HeightField a_metre_up() {
  const HeightField surface = make_gaussian_surface({}, 22);
  return make_height_field(surface.z.cast<double>() + 1e6, surface.dx, surface.dy);
}

/// A dust grain, or a pixel that the instrument made up.
HeightField with_spike(double height) {
  HeightField surface = make_gaussian_surface({}, 1);
  surface.z(20, 30) += static_cast<float>(height);
  return surface;
}

const std::vector<ZooEntry>& zoo() {
  static const std::vector<ZooEntry> entries = {
      {"rough", [] { return make_gaussian_surface({}, 1); }},
      {"steep", [] { return make_gaussian_surface({.rms = 1, .tau_x = 1.5, .tau_y = 1.5}, 2); }},
      {"brushed", [] { return make_gaussian_surface({.tau_x = 12, .tau_y = 1.5}, 3); }},
      {"mirror", [] { return make_gaussian_surface({.rms = 0.005}, 4); }},
      {"flat", [] { return grid_surface(48, 64, 0.11, 0.11, [](auto, auto) { return 0.0; }); }},
      {"holes", [] { return with_missing(make_gaussian_surface({}, 5), 0.04, 6); }},
      {"mostly_missing", [] { return with_missing(make_gaussian_surface({}, 5), 0.7, 7); }},
      {"missing_95_percent",
       [] { return with_missing(make_gaussian_surface({.rows = 120, .cols = 120}, 5), 0.95, 8); }},
      {"missing_border", missing_border},
      {"all_missing", [] { return grid_surface(48, 64, 0.11, 0.11, [](auto, auto) { return kMissing; }); }},
      {"one_cell",
       [] {
         return grid_surface(2, 2, 0.11, 0.11,
                             [](auto j, auto i) { return 0.03 * static_cast<double>(i - 2 * j); });
       }},
      {"one_triangle", one_triangle},
      {"single_row", [] { return make_gaussian_surface({.rows = 1, .cols = 300}, 10); }},
      {"strip", [] { return make_gaussian_surface({.rows = 2, .cols = 300}, 10); }},
      {"column", [] { return make_gaussian_surface({.rows = 300, .cols = 2}, 11); }},
      {"tall_pixels",
       [] { return make_gaussian_surface({.rows = 24, .cols = 100, .dx = 0.05, .dy = 0.5}, 12); }},
      {"wide_pixels",
       [] { return make_gaussian_surface({.rows = 100, .cols = 24, .dx = 0.5, .dy = 0.05}, 13); }},
      {"longer_than_the_period", [] { return make_gaussian_surface({.rows = 90, .cols = 150}, 14); }},
      {"many_periods", [] { return make_gaussian_surface({.rows = 60, .cols = 150}, 14); }},
      {"odd_size", [] { return make_gaussian_surface({.rows = 31, .cols = 47}, 16); }},
      {"coarse_pitch",
       [] { return make_gaussian_surface({.rows = 20, .cols = 24, .dx = 1, .dy = 1, .rms = 0.5}, 19); }},
      {"cliffs_of_ten_micrometres",
       [] {
         return grid_surface(40, 40, 0.5, 0.5,
                             [](auto j, auto i) { return (i / 8 + j / 10) % 2 == 0 ? 0.0 : 10.0; });
       }},
      {"slopes_of_ten",
       [] {
         return grid_surface(32, 32, 0.1, 0.1,
                             [](auto j, auto i) { return static_cast<double>((i + 2 * j) % 2); });
       }},
      {"a_staircase_of_thirty_micrometres", staircase},
      {"a_hundred_micrometres",
       [] {
         return grid_surface(4, 101, 1, 0.5, [](auto j, auto i) {
           return static_cast<double>(i) + 0.05 * std::sin(static_cast<double>(i * j));
         });
       }},
      {"a_metre_up", a_metre_up},
      {"a_spike_of_ten_micrometres", [] { return with_spike(10); }},
      {"a_spike_of_a_millimetre", [] { return with_spike(1000); }},
      {"a_spike_of_ten_to_the_thirty", [] { return with_spike(1e30); }},
  };
  return entries;
}

}  // namespace

HeightField grid_surface(Eigen::Index rows, Eigen::Index cols, double dx, double dy,
                         const std::function<double(Eigen::Index, Eigen::Index)>& z) {
  return make_height_field(Grid<double>::NullaryExpr(rows, cols, z), dx, dy);
}

std::vector<std::string> zoo_names() {
  std::vector<std::string> names;
  for (const ZooEntry& entry : zoo())
    names.push_back(entry.name);
  return names;
}

HeightField zoo_surface(const std::string& name) {
  const auto found =
      std::find_if(zoo().begin(), zoo().end(), [&](const ZooEntry& entry) { return entry.name == name; });
  if (found == zoo().end()) throw InputError("the zoo has no surface called " + name);
  return found->make();
}

}  // namespace micro::testing
