#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace micro::bench {

/// One point of a curve of error against run time.
struct CurvePoint {
  std::string part = {};       ///< what is estimated: "kirchhoff", …
  std::string surface = {};    ///< on what, see surfaces.h
  std::string estimator = {};  ///< by what
  double asked = 0;            ///< the tolerance, or the knob that takes its place
  double error = 0;            ///< relative L2 error reached, measured against the oracle
  double error_core_free = 0;  ///< the same where the part has a second measure, else equal to `error`
  double seconds = 0;          ///< for the whole answer
  enum class Reached { Yes, No, NotAsked } reached = Reached::NotAsked;  ///< what the estimator itself says
  std::string note =
      {};  ///< "paper": the choice of [Dong15]; "scaled": time for some directions, scaled to all
};

/// The CSV's first line, and a point as one line of it.
void write_header(std::FILE* csv);
void write(std::FILE* csv, const CurvePoint& point);

}  // namespace micro::bench
