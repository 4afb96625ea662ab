#pragma once

#include <functional>
#include <string>
#include <vector>

#include "height/height_field.h"

namespace micro::testing {

/// rows × cols heights z(j, i) in µm, pitch in µm.
HeightField grid_surface(Eigen::Index rows, Eigen::Index cols, double dx, double dy,
                         const std::function<double(Eigen::Index j, Eigen::Index i)>& z);

/// The names of the zoo of extreme surfaces: small ones, so that a slow oracle can judge every number.
std::vector<std::string> zoo_names();

/// The surface of that name. Throws InputError for a name that no surface has.
HeightField zoo_surface(const std::string& name);

}  // namespace micro::testing
