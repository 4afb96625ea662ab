#include "testing/step_between.h"

#include <cmath>

namespace micro::testing {

Vector5 step_between(const SlopeFrame& from, const SlopeFrame& to) {
  const Vec2 t = from.whiten(to.centre);
  return (Vector5() << t.x(), t.y(), std::log(to.l11 / from.l11),
          (to.l21 - from.l21 * to.l11 / from.l11) / from.l22, std::log(to.l22 / from.l22))
      .finished();
}

}  // namespace micro::testing
