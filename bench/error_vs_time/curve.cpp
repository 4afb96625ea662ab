#include "error_vs_time/curve.h"

namespace micro::bench {

void write_header(std::FILE* csv) {
  std::fprintf(csv, "part,surface,estimator,asked,error,error_core_free,seconds,reached,note\n");
}

void write(std::FILE* csv, const CurvePoint& p) {
  const char* reached = p.reached == CurvePoint::Reached::Yes  ? "yes"
                        : p.reached == CurvePoint::Reached::No ? "no"
                                                               : "";
  std::fprintf(csv, "%s,%s,%s,%g,%.3g,%.3g,%.4g,%s,%s\n", p.part.c_str(), p.surface.c_str(),
               p.estimator.c_str(), p.asked, p.error, p.error_core_free, p.seconds, reached, p.note.c_str());
  std::fflush(csv);
}

}  // namespace micro::bench
