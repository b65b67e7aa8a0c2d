#pragma once

#include <string>

#include "cpplus/pipeline/simulation_summary.h"
#include "cpplus/simulate/simulate.h"

namespace cpplus {

/// Records a district and writes it on the way: memory does not grow with its area or its points. The folder has the
/// files of other worlds but scans, labels, checkerboards and edges; it appears whole or not at all, and where there is
/// a world already, takes its place. Throws Error where it cannot be written.
SimulationSummary write_district(const SimulateOptions& options, const std::string& directory);

}  // namespace cpplus
