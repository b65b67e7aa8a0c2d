#include "cpplus/visibility/projected_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "cpplus/cloud/node_range.h"
#include "cpplus/core/vector_clones.h"
#include "cpplus/visibility/hidden_ranges.h"
#include "cpplus/visibility/nodes_in_view.h"
#include "cpplus/visibility/point_block.h"
#include "cpplus/visibility/point_spacing.h"

namespace cpplus {
namespace {

// Points of some nodes, a block at a time.
class PointProjector {
 public:
  PointProjector(const VoxelMap& map, const PlaneBuffer& planes, double max_distance_m,
                 const VisitProjectedPoints& visit)
      : camera_(planes.camera),
        min_cos_(static_cast<float>(std::cos(planes.camera.max_view_angle()))),
        max_range_(static_cast<float>(max_distance_m)),
        visit_(visit),
        block_(planes.camera, planes.camera_from_map, map.origin()) {}

  // first: index of the first position.
  void add(std::span<const Eigen::Vector3f> positions, uint32_t first, float spacing) {
    while (!positions.empty()) {
      const size_t count = std::min(positions.size(), block_.room());
      std::fill_n(&spacing_[block_.size()], count, spacing);
      std::iota(&index_[block_.size()], &index_[block_.size()] + count, first);
      first += static_cast<uint32_t>(count);
      block_.add(positions.first(count));
      positions = positions.subspan(count);
      if (block_.full()) flush();
    }
  }

  void flush() {
    block_.project();
    look_at_block();
    size_t count = 0;
    for (size_t i = 0; i < block_.size(); ++i) {
      // Written in any case: most are in view, and the next one takes the place of one that is not.
      points_[count] = {{block_.column(i), block_.row(i)}, block_.range(i), spacing_[i]};
      index_[count] = index_[i];
      count += in_view_[i];
    }
    visit_({points_.data(), count}, {index_.data(), count});
    block_.clear();
  }

 private:
  static constexpr float kMinRangeM = 1e-3f;

  // Which points of the block are in view, and their spacings in pixels for those in metres.
  CPPLUS_VECTOR_CLONES void look_at_block() {
    const float pixels_per_radian = static_cast<float>(camera_.pixels_per_radian());
    const float last_column = static_cast<float>(camera_.width()) - 0.5f;
    const float last_row = static_cast<float>(camera_.height()) - 0.5f;
    for (size_t i = 0; i < block_.size(); ++i) {
      const float range = block_.range(i);
      const float column = block_.column(i);
      const float row = block_.row(i);
      in_view_[i] = (column >= -0.5f) & (row >= -0.5f) & (column < last_column) & (row < last_row) &
                    (range <= max_range_) & (range > kMinRangeM) & (block_.z(i) >= min_cos_ * range);
      spacing_[i] = spacing_[i] / range * pixels_per_radian;
    }
  }

  const Camera& camera_;
  float min_cos_;
  float max_range_;
  const VisitProjectedPoints& visit_;
  PointBlock block_;
  std::array<float, PointBlock::kSize> spacing_;
  std::array<uint32_t, PointBlock::kSize> index_;
  std::array<uint8_t, PointBlock::kSize> in_view_;
  std::array<ProjectedPoint, PointBlock::kSize> points_;
};

}  // namespace

void project_points(const VoxelMap& map, const std::vector<float>& leaf_spacing, const PlaneBuffer& planes,
                    double max_distance_m, const VisitProjectedPoints& visit) {
  if (map.num_layers() == 0) return;
  const int layer = point_spacing_layer(map);
  PointProjector projector(map, planes, max_distance_m, visit);
  for (const uint32_t node :
       nodes_in_view(map, layer, planes.camera, planes.camera_from_map, max_distance_m, 0.0, HiddenRanges(planes))) {
    const float spacing = leaf_spacing[leaves_of(map, layer, node).begin];
    if (!std::isfinite(spacing)) continue;
    const uint32_t begin = map.points_begin(layer, node);
    projector.add(map.positions().subspan(begin, map.points_end(layer, node) - begin), begin, spacing);
  }
  projector.flush();
}

}  // namespace cpplus
