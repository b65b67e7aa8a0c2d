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

}  // namespace

void IndexCommandOptions::validate() const {
  require_option("out", out);
  check_option(memory_mb >= 64 && memory_mb <= 1 << 20, "memory_mb", "[64, 1048576]", memory_mb);
  voxel_map.validate();
}

IndexSummary index_command(const std::vector<std::string>& maps, const IndexCommandOptions& options) {
  options.validate();
  if (!is_voxel_map_file(options.out)) {
    throw Error(fmt::format("{}: the file of a voxel map must end in .vox", options.out));
  }
  for (const char* ending : {"", ".scratch"}) remove_leftovers(options.out + ending);
  const size_t memory_bytes = (static_cast<size_t>(options.memory_mb) - kBaseMb) << 20;
  return index_point_clouds(maps, options.voxel_map, memory_bytes, options.out);
}

}  // namespace cpplus
