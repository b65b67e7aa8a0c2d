#include "cpplus/pipeline/map_cache.h"

#include <fmt/format.h>

#include <filesystem>

#include "cpplus/core/error.h"
#include "cpplus/io/voxel_map_file.h"
#include "cpplus/io/voxel_map_format.h"
#include "cpplus/pipeline/index_command.h"

namespace cpplus {

namespace fs = std::filesystem;

std::string cached_map(const std::string& map, const std::string& cache, const VoxelMapOptions& options) {
  if (cache.empty() || is_voxel_map_file(map)) return map;
  std::error_code failure;
  const auto size = fs::file_size(map, failure);
  const auto time = failure ? fs::file_time_type() : fs::last_write_time(map, failure);
  if (failure) throw Error(fmt::format("{}: cannot read: {}", map, failure.message()));
  IndexCommandOptions index;
  index.voxel_map = options;
  index.out = (fs::path(cache) / fmt::format("{}-{}-{}-{}-{}-v{}.vox", fs::path(map).filename().string(), size,
                                             time.time_since_epoch().count(), options.root_size_m, options.leaf_size_m,
                                             kVoxelMapVersion))
                  .string();
  if (!fs::exists(index.out)) index_command({map}, index);
  return index.out;
}

}  // namespace cpplus
