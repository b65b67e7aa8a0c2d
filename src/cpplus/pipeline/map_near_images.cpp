#include "cpplus/pipeline/map_near_images.h"

#include <fmt/format.h>

#include <numeric>
#include <utility>

#include "cpplus/cloud/map_part.h"
#include "cpplus/core/error.h"
#include "cpplus/core/log.h"

namespace cpplus {
namespace {

/// A part with more of the map's points than this is not worth a copy, which costs two thirds of what is found of it.
constexpr double kMostWorthACopy = 0.6;

size_t num_points_in(const VoxelMap& map, const std::vector<uint32_t>& roots) {
  size_t count = 0;
  for (const uint32_t root : roots) count += map.num_points(0, root);
  return count;
}

}  // namespace

std::vector<uint32_t> roots_near_places(const VoxelMap& map, const std::vector<Eigen::Vector3d>& places,
                                        double reach_m) {
  std::vector<uint32_t> roots = roots_near(map, places, reach_m);
  const size_t num_near = num_points_in(map, roots);
  if (static_cast<double>(num_near) > kMostWorthACopy * static_cast<double>(map.num_points())) {
    roots.resize(map.num_nodes(0));
    std::iota(roots.begin(), roots.end(), 0u);
  } else {
    log_info(
        fmt::format("{} of the map's {} points lie within {:.0f} m of an image", num_near, map.num_points(), reach_m));
  }
  return roots;
}

NearMap part_near(const std::string& path, const PointMap& points, std::vector<uint32_t> roots) {
  NearMap near;
  near.roots = std::move(roots);
  try {
    near.points = part_of_map(points, near.roots);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: damaged: {}", path, error.what()));
  }
  return near;
}

NearMap map_near_places(const std::string& path, const PointMap& points, const std::vector<Eigen::Vector3d>& places,
                        double reach_m) {
  return part_near(path, points, roots_near_places(points.map, places, reach_m));
}

std::vector<Eigen::Vector3d> camera_centers(const SparseModel& model) {
  std::vector<Eigen::Vector3d> places;
  places.reserve(model.images.size());
  for (const PosedImage& image : model.images) places.push_back(camera_center(image.camera_from_map));
  return places;
}

}  // namespace cpplus
