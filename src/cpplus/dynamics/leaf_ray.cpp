#include "cpplus/dynamics/leaf_ray.h"

namespace cpplus {

LeafRayCaster::LeafRayCaster(const VoxelMap& map, const Eigen::Vector3d& origin_in_map, double radius_m)
    : map_(map), leaf_layer_(map.leaf_layer()) {
  const std::vector<uint32_t> roots = map.roots_in_radius(origin_in_map, radius_m);
  const Eigen::Vector3i origin_root = map.key_of(0, origin_in_map);
  low_ = origin_root;
  Eigen::Vector3i high = origin_root;
  for (const uint32_t root : roots) {
    low_ = low_.cwiseMin(map.key(0, root));
    high = high.cwiseMax(map.key(0, root));
  }
  size_ = high - low_ + Eigen::Vector3i::Ones();
  last_cell_ = size_ * (1 << leaf_layer_) - Eigen::Vector3i::Ones();
  roots_.assign(static_cast<size_t>(size_.x()) * static_cast<size_t>(size_.y()) * static_cast<size_t>(size_.z()),
                no_voxel);
  for (const uint32_t root : roots) {
    const Eigen::Vector3i place = map.key(0, root) - low_;
    roots_[static_cast<size_t>((place.z() * size_.y() + place.y()) * size_.x() + place.x())] = root;
  }
  origin_in_leaves_ = (origin_in_map - low_.cast<double>() * map.options().root_size_m) / map.options().leaf_size_m;
}

}  // namespace cpplus
