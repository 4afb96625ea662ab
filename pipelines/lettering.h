#pragma once

#include <string_view>

#include "io/png.h"

namespace micro {

constexpr Eigen::Index kLetterWidth = 6, kLetterHeight = 7;
constexpr Rgb kInk = {40, 40, 40};

/// Draws text into a picture from (row, col) on, in capitals, cut off after `width` points; a text too long
/// loses its beginning. What lies outside the picture is not drawn.
void draw_text(Picture& picture, Eigen::Index row, Eigen::Index col, Eigen::Index width,
               std::string_view text);

}  // namespace micro
