#pragma once

#include <gtest/gtest.h>

#include "fit/fit.h"
#include "testing/step_between.h"

namespace micro::testing {

constexpr double kRecovered = 1e-5;  ///< relative L2 of the table, and widths in slope space

/// Is the frame found that an exact table was made of? `k` says which case it is.
inline void expect_recovered(const Fit& found, const SlopeFrame& frame, std::uint64_t k) {
  EXPECT_LE(found.rel_rms, kRecovered) << "case " << k << " " << name_of(found.status);
  EXPECT_LE(step_between(frame, found.frame).cwiseAbs().maxCoeff(), kRecovered) << "case " << k;
}

}  // namespace micro::testing
