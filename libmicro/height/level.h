#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "height/height_field.h"

namespace micro {

/// What is subtracted before anything is computed: nothing, the mean, the least-squares plane, or the
/// least-squares quadratic (ISO 25178's form removal for curved parts).
enum class Level { None, Mean, Plane, Quadratic };

inline constexpr std::array kLevels = {Level::None, Level::Mean, Level::Plane, Level::Quadratic};

/// none | mean | plane | quadratic.
std::string_view name_of(Level level);

/// The level of that name, if there is one.
std::optional<Level> level_from_name(std::string_view name);

/// Subtracts the least-squares polynomial over the valid points, in double. The result's `mean` is 0, except
/// for Level::None, which returns the surface untouched. What the points cannot decide (one row, one column,
/// fewer points than coefficients) takes the fit of minimum norm, so the result is always finite where the
/// surface is.
HeightField level(HeightField surface, Level level);

}  // namespace micro
