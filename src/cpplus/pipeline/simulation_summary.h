#pragma once

#include <cstddef>

namespace cpplus {

struct SimulationSummary {
  size_t images = 0;
  size_t scans = 0;
  size_t map_points = 0;
  size_t moving_map_points = 0;
  size_t checkerboards = 0;
  size_t true_edges = 0;
};

}  // namespace cpplus
