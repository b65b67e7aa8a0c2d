#include "cpplus/pipeline/colored_map.h"

#include <algorithm>
#include <span>

#include "cpplus/io/ordered_points.h"
#include "cpplus/io/point_cloud_io.h"

namespace cpplus {
namespace {

PointAttributes attributes_of(const PointMap& points) {
  PointAttributes attributes;
  attributes.intensities = !points.intensities.empty();
  attributes.stamps_s = !points.stamps_s.empty();
  return attributes;
}

/// The points of a map with their colours, some at a time in map order.
class ColoredBlocks {
 public:
  ColoredBlocks(const PointMap& points, const NearMap& near, const PointCloud& colored, const GrayScale& grays)
      : points_(points), near_(near), colored_(colored), grays_(grays) {}

  /// Hands blocks of about kBlockPoints points to the order.
  void add_to(OrderedPoints* ordered) {
    const VoxelMap& map = points_.map;
    for (uint32_t root = 0; root < map.num_nodes(0); ++root) {
      const bool is_near = next_near_ < near_.roots.size() && near_.roots[next_near_] == root;
      const uint32_t end = map.points_end(0, root);
      add_run(map.points_begin(0, root), end, is_near);
      if (is_near) ++next_near_;
      if (end - begin_ >= kBlockPoints || root + 1 == map.num_nodes(0)) flush(end, ordered);
    }
  }

 private:
  static constexpr uint32_t kBlockPoints = 1 << 16;

  void add_run(uint32_t begin, uint32_t end, bool is_near) {
    for (uint32_t i = begin; i < end; ++i) {
      const uint32_t k = is_near ? near_.points.map.input_index(num_near_++) : 0;
      const bool is_seen = is_near && colored_.num_views[k] > 0;
      block_.colors.push_back(is_seen ? colored_.colors[k] : gray_of(i));
      block_.num_views.push_back(is_seen ? colored_.num_views[k] : uint16_t{0});
      block_.best_images.push_back(is_seen ? colored_.best_images[k] : 0u);
      block_.color_spreads.push_back(is_seen ? colored_.color_spreads[k] : uint8_t{0});
    }
  }

  Rgb gray_of(uint32_t i) const {
    return points_.intensities.empty() ? grays_.gray() : grays_.gray(points_.intensities[i]);
  }

  /// Points [begin_, end) are complete.
  void flush(uint32_t end, OrderedPoints* ordered) {
    const auto assign = [&](const auto& from, auto* to) {
      if (from.empty()) return;
      const auto run = from.subspan(begin_, end - begin_);
      to->assign(run.begin(), run.end());
    };
    assign(points_.map.positions(), &block_.positions);
    assign(points_.intensities, &block_.intensities);
    assign(points_.stamps_s, &block_.stamps_s);
    ordered->add(block_, points_.map.arrays().input_indices.subspan(begin_, end - begin_));
    block_ = {};
    begin_ = end;
  }

  const PointMap& points_;
  const NearMap& near_;
  const PointCloud& colored_;
  const GrayScale& grays_;
  PointCloud block_;
  uint32_t begin_ = 0;     // of the block, in map order
  size_t next_near_ = 0;   // into near_.roots
  uint32_t num_near_ = 0;  // near points so far
};

}  // namespace

void write_colored_map(const std::string& path, const PointMap& points, const NearMap& near, const PointCloud& colored,
                       const GrayScale& grays, const std::string& out) {
  OrderedPoints ordered(path, out, points.map.num_points(), attributes_of(points));
  ColoredBlocks(points, near, colored, grays).add_to(&ordered);
  write_point_cloud(out, ordered.finish(points.map.origin(), points.las_frame));
}

}  // namespace cpplus
