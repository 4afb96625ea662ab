#include "pipelines/version.h"

namespace micro {

std::string_view version() {
  return MICROBRDF_VERSION;
}

}  // namespace micro
