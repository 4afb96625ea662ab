#pragma once

#include "fit/normal_equations.h"

namespace micro::testing {

/// The step that leads from one frame to another, in widths of the first: moved(from, step) is `to`.
Vector5 step_between(const SlopeFrame& from, const SlopeFrame& to);

}  // namespace micro::testing
