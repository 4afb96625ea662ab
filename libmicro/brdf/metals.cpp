#include "brdf/metals.h"

#include <algorithm>

#include "core/error.h"

namespace micro {
namespace {

constexpr const char* kNoble =
    "P. B. Johnson and R. W. Christy, Optical constants of the noble metals, Phys. Rev. B 6, 4370-4379 "
    "(1972)";
constexpr const char* kTransition =
    "P. B. Johnson and R. W. Christy, Optical constants of transition metals: Ti, V, Cr, Mn, Fe, Co, Ni, and "
    "Pd, Phys. Rev. B 9, 5056-5070 (1974)";
constexpr const char* kRakic =
    "A. D. Rakic, Algorithm for the determination of intrinsic optical constants of metal films: application "
    "to aluminum, Appl. Opt. 34, 4755-4767 (1995)";
constexpr const char* kSteel =
    "B. Karlsson and C. G. Ribbing, Optical constants and spectral selectivity of stainless steel and its "
    "oxides, J. Appl. Phys. 53, 6340-6346 (1982), read from its figure by refractiveindex.info";

std::vector<Metal> published() {
  const std::vector<double> noble = {0.3542, 0.3679, 0.3815, 0.3974, 0.4133, 0.4305, 0.4509, 0.4714, 0.4959,
                                     0.5209, 0.5486, 0.5821, 0.6168, 0.6595, 0.7045, 0.756,  0.8211, 0.892};
  const std::vector<double> transition = {0.354, 0.368, 0.381, 0.397, 0.413, 0.431, 0.451, 0.471, 0.496,
                                          0.521, 0.549, 0.582, 0.617, 0.659, 0.704, 0.756, 0.821, 0.892};
  return {
      {"Al",
       "aluminium, evaporated",
       kRakic,
       {{0.32628, 0.36466, 0.41328, 0.4428, 0.47687, 0.5166, 0.56357, 0.61993, 0.65225, 0.68881, 0.72932,
         0.77491, 0.79478, 0.81569, 0.83774},
        {0.31474, 0.39877, 0.52135, 0.6079, 0.7278, 0.8734, 1.0728, 1.366, 1.5724, 1.8301, 2.1606, 2.6154,
         2.7675, 2.7668, 2.6945},
        {3.9165, 4.3957, 5.0008, 5.3676, 5.7781, 6.2418, 6.7839, 7.4052, 7.7354, 8.0601, 8.3565, 8.4914,
         8.3866, 8.2573, 8.1878}}},
      {"Cu",
       "copper",
       kNoble,
       {noble,
        {1.37, 1.36, 1.33, 1.32, 1.28, 1.25, 1.24, 1.25, 1.22, 1.18, 1.02, 0.7, 0.3, 0.22, 0.21, 0.24, 0.26,
         0.3},
        {1.916, 1.975, 2.045, 2.116, 2.207, 2.305, 2.397, 2.483, 2.564, 2.608, 2.577, 2.704, 3.205, 3.747,
         4.205, 4.665, 5.18, 5.768}}},
      {"Au",
       "gold",
       kNoble,
       {noble,
        {1.5, 1.48, 1.46, 1.47, 1.46, 1.45, 1.38, 1.31, 1.04, 0.62, 0.43, 0.29, 0.21, 0.14, 0.13, 0.14, 0.16,
         0.17},
        {1.866, 1.895, 1.933, 1.952, 1.958, 1.948, 1.914, 1.849, 1.833, 2.081, 2.455, 2.863, 3.272, 3.697,
         4.103, 4.542, 5.083, 5.663}}},
      {"Ag",
       "silver",
       kNoble,
       {noble,
        {0.1, 0.07, 0.05, 0.05, 0.05, 0.04, 0.04, 0.05, 0.05, 0.05, 0.06, 0.05, 0.06, 0.05, 0.04, 0.03, 0.04,
         0.04},
        {1.419, 1.657, 1.864, 2.07, 2.275, 2.462, 2.657, 2.869, 3.093, 3.324, 3.586, 3.858, 4.152, 4.483,
         4.838, 5.242, 5.727, 6.312}}},
      {"Fe",
       "iron",
       kTransition,
       {transition,
        {1.93, 2.02, 2.12, 2.24, 2.35, 2.48, 2.59, 2.67, 2.74, 2.86, 2.95, 2.94, 2.88, 2.92, 2.86, 2.87, 2.94,
         2.96},
        {2.35, 2.43, 2.5, 2.58, 2.65, 2.71, 2.77, 2.82, 2.88, 2.91, 2.93, 2.99, 3.05, 3.1, 3.19, 3.28, 3.39,
         3.56}}},
      {"Cr",
       "chromium",
       kTransition,
       {transition,
        {1.84, 1.87, 1.92, 2, 2.08, 2.19, 2.33, 2.51, 2.75, 2.94, 3.18, 3.22, 3.17, 3.09, 3.05, 3.08, 3.2,
         3.3},
        {2.64, 2.69, 2.74, 2.83, 2.93, 3.04, 3.14, 3.24, 3.3, 3.33, 3.33, 3.3, 3.3, 3.34, 3.39, 3.42, 3.48,
         3.52}}},
      {"Ni",
       "nickel",
       kTransition,
       {transition,
        {1.74, 1.7, 1.72, 1.72, 1.7, 1.71, 1.73, 1.78, 1.82, 1.85, 1.92, 1.96, 1.99, 1.99, 2.06, 2.13, 2.26,
         2.4},
        {2.32, 2.4, 2.48, 2.57, 2.69, 2.82, 2.95, 3.09, 3.25, 3.42, 3.61, 3.8, 4.02, 4.26, 4.5, 4.73, 4.97,
         5.23}}},
      {"Ti",
       "titanium",
       kTransition,
       {transition,
        {1.82, 1.9, 1.99, 2.08, 2.14, 2.21, 2.27, 2.32, 2.36, 2.44, 2.54, 2.6, 2.67, 2.76, 2.86, 3, 3.21,
         3.29},
        {2.87, 2.9, 2.93, 2.95, 2.98, 3.01, 3.04, 3.1, 3.19, 3.3, 3.43, 3.58, 3.72, 3.84, 3.96, 4.01, 4.01,
         3.96}}},
      {"steel",
       "austenitic stainless steel, 18.5 % Cr, 9.3 % Ni",
       kSteel,
       {{0.34, 0.36, 0.38, 0.4,  0.42, 0.44, 0.46, 0.48, 0.5,  0.52, 0.54, 0.56, 0.58,
         0.6,  0.62, 0.64, 0.66, 0.68, 0.7,  0.72, 0.74, 0.76, 0.78, 0.8,  0.82, 0.84},
        {1.395,  1.4354, 1.4786, 1.5249, 1.5762, 1.6386, 1.7169, 1.7921, 1.8636,
         1.9349, 2.0072, 2.0807, 2.1557, 2.2325, 2.3122, 2.3962, 2.4839, 2.5731,
         2.6617, 2.7486, 2.8331, 2.9143, 2.9915, 3.0655, 3.1374, 3.2096},
        {2.4165, 2.5447, 2.6681, 2.7925, 2.924,  3.0555, 3.1785, 3.2933, 3.401,
         3.5072, 3.6166, 3.7298, 3.8451, 3.9594, 4.0504, 4.1378, 4.2261, 4.3155,
         4.4066, 4.5036, 4.5851, 4.6435, 4.7009, 4.7583, 4.816,  4.8744}}},
  };
}

}  // namespace

const std::vector<Metal>& metals() {
  static const std::vector<Metal> all = published();
  return all;
}

const Metal& metal(std::string_view name) {
  const auto found = std::ranges::find(metals(), name, &Metal::name);
  if (found != metals().end()) return *found;
  std::string names;
  for (const Metal& known : metals())
    names += (names.empty() ? "" : ", ") + known.name;
  throw InputError("no optical constants of '" + std::string(name) + "' are known; there are " + names);
}

}  // namespace micro
