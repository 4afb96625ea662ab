#pragma once

#include "pipelines/ndf_of_scans.h"
#include "pipelines/run_sums.h"

namespace micro {

/// Means, plan and what the instrument's signature makes of them, from the sums of all scans.
NdfResult finish_sums(RunSums sums, const NdfRequest& request);

}  // namespace micro
