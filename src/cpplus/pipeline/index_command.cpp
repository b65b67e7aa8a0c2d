#include "cpplus/pipeline/index_command.h"

#include <fmt/format.h>

#include "cpplus/core/error.h"
#include "cpplus/core/options.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/voxel_map_file.h"

namespace cpplus {
namespace {

/// What the program takes whatever the points.
constexpr size_t kBaseMb = 32;

void find_features(const IndexCommandOptions& options) {
  RefineImagesOptions stages;
  stages.planes = options.planes;
  stages.map_edges = options.map_edges;
  FeatureStore(options.out, map_voxel_map_file(options.out), stages, options.tiles).find_all();
}

}  // namespace

void IndexCommandOptions::validate() const {
  require_option("out", out);
  check_option(memory_mb >= 64 && memory_mb <= 1 << 20, "memory_mb", "[64, 1048576]", memory_mb);
  voxel_map.validate();
  tiles.validate();
  planes.validate();
  map_edges.validate();
}

IndexSummary index_command(const std::vector<std::string>& maps, const IndexCommandOptions& options) {
  options.validate();
  if (!is_voxel_map_file(options.out)) {
    throw Error(fmt::format("{}: the file of a voxel map must end in .vox", options.out));
  }
  for (const char* ending : {"", ".scratch"}) remove_leftovers(options.out + ending);
  const size_t memory_bytes = (static_cast<size_t>(options.memory_mb) - kBaseMb) << 20;
  const IndexSummary summary = index_point_clouds(maps, options.voxel_map, memory_bytes, options.out);
  remove_features(options.out);
  if (options.features) find_features(options);
  return summary;
}

}  // namespace cpplus
