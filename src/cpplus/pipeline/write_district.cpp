#include "cpplus/pipeline/write_district.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "cpplus/io/atomic_file.h"
#include "cpplus/io/pcd_writer.h"
#include "cpplus/pipeline/atomic_folder.h"
#include "cpplus/pipeline/world_files.h"
#include "cpplus/simulate/simulate_district.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMap = "map.pcd";

/// Whether a world has a file or folder of this name.
bool is_of_a_world(const std::string& name) {
  constexpr std::array<std::string_view, 8> kNames = {kMap,    "images",       "scans",         "stamps.txt",
                                                      "truth", "coarse_small", "coarse_medium", "coarse_large"};
  return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

}  // namespace

SimulationSummary write_district(const SimulateOptions& options, const std::string& directory) {
  remove_leftovers(directory);
  AtomicFolder folder(directory);
  const std::string temporary = folder.temporary().string();
  PcdWriter map(temporary + "/" + kMap);
  const SimulatedWorld world =
      simulate_district(options, {[&](const PointCloud& points) { map.add(points); },
                                  [&](const SimulatedImage& image) { write_image(image, temporary); }});
  write_scan_poses(world, temporary);
  write_image_lists(world, temporary);
  write_models(world, temporary);
  map.commit();
  if (fs::exists(folder.target()) && !fs::is_empty(folder.target())) {
    folder.commit_into(is_of_a_world, kMap);
  } else {
    folder.commit();
  }
  SimulationSummary summary;
  summary.images = world.images.size();
  summary.scans = world.scans.size();
  summary.map_points = map.num_points();
  return summary;
}

}  // namespace cpplus
