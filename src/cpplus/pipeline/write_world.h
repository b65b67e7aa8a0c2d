#pragma once

#include <string>

#include "cpplus/pipeline/simulation_summary.h"
#include "cpplus/simulate/simulate.h"

namespace cpplus {

/// Writes a world as a folder of scenes is laid out (docs/simulator.md lists the files). Parent folders are made.
/// Throws Error where a file cannot be written.
SimulationSummary write_world(const SimulatedWorld& world, const std::string& directory);

/// Simulates and writes: what `cpplus simulate --scene NAME --seed N --out DIR` does. A district is written while it is
/// recorded (write_district.h).
SimulationSummary simulate(const SimulateOptions& options, const std::string& directory);

}  // namespace cpplus
