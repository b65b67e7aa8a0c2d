#include "cpplus/pipeline/map_colors.h"

#include <algorithm>
#include <utility>

namespace cpplus {

MapColors::MapColors(const VoxelMap& map, std::vector<uint32_t> roots, const std::string& target)
    : map_(map), roots_(std::move(roots)), file_(target) {
  uint64_t num_points = 0;
  points_before_.reserve(roots_.size());
  for (const uint32_t root : roots_) {
    points_before_.push_back(num_points);
    num_points += map_.num_points(0, root);
  }
}

void MapColors::write(uint32_t root, std::span<const ColoredPoint> points) {
  const auto at = std::lower_bound(roots_.begin(), roots_.end(), root) - roots_.begin();
  file_.write(points_before_[static_cast<size_t>(at)] * sizeof(ColoredPoint), points.data(), points.size_bytes());
}

std::vector<ColoredPoint> MapColors::read(uint32_t root) const {
  const auto found = std::lower_bound(roots_.begin(), roots_.end(), root);
  if (found == roots_.end() || *found != root) return {};
  std::vector<ColoredPoint> points(map_.num_points(0, root));
  file_.read(points_before_[static_cast<size_t>(found - roots_.begin())] * sizeof(ColoredPoint), points.data(),
             points.size() * sizeof(ColoredPoint));
  return points;
}

}  // namespace cpplus
