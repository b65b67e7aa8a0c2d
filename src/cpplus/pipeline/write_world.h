#pragma once

#include <cstddef>
#include <string>

#include "cpplus/geometry/sparse_model.h"
#include "cpplus/simulate/simulate.h"

namespace cpplus {

struct SimulationSummary {
  size_t images = 0;
  size_t scans = 0;
  size_t map_points = 0;
  size_t moving_map_points = 0;
  size_t checkerboards = 0;
  size_t true_edges = 0;
};

/// Writes a world as a folder of scenes is laid out (docs/simulator.md lists the files). Parent folders are made.
/// Throws Error where a file cannot be written.
SimulationSummary write_world(const SimulatedWorld& world, const std::string& directory);

/// Simulates and writes: what `cpplus simulate --scene NAME --seed N --out DIR` does.
SimulationSummary simulate(const SimulateOptions& options, const std::string& directory);

/// The COLMAP model (one camera, no points) of the world's images with the given poses, in the order of the images.
SparseModel sparse_model_of(const SimulatedWorld& world, const std::vector<Rigid3>& camera_from_map);

}  // namespace cpplus
