#include "cpplus/pipeline/colored_map.h"

#include <vector>

#include "cpplus/core/parallel.h"
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
  ColoredBlocks(const PointMap& points, const MapColors& colors, const GrayScale& grays)
      : points_(points), colors_(colors), grays_(grays) {}

  /// Hands blocks of about kBlockPoints points to the order.
  void add_to(OrderedPoints* ordered) {
    const VoxelMap& map = points_.map;
    uint32_t begin = 0;
    for (uint32_t root = 0; root < map.num_nodes(0); ++root) {
      if (map.points_end(0, root) - map.points_begin(0, begin) < kBlockPoints && root + 1 < map.num_nodes(0)) continue;
      add_roots(begin, root + 1);
      flush(map.points_end(0, root), ordered);
      begin = root + 1;
    }
  }

 private:
  static constexpr uint32_t kBlockPoints = 1 << 16;

  void add_roots(uint32_t begin, uint32_t end) {
    std::vector<std::vector<ColoredPoint>> colored(end - begin);
    parallel_for_each(colored.size(),
                      [&](size_t k) { colored[k] = colors_.of_root(begin + static_cast<uint32_t>(k)); });
    for (uint32_t root = begin; root < end; ++root) {
      add_run(points_.map.points_begin(0, root), points_.map.points_end(0, root), colored[root - begin]);
    }
  }

  /// `colored`: of these points, or empty.
  void add_run(uint32_t begin, uint32_t end, const std::vector<ColoredPoint>& colored) {
    for (uint32_t i = begin; i < end; ++i) {
      const ColoredPoint point = colored.empty() ? ColoredPoint{} : colored[i - begin];
      block_.colors.push_back(point.num_views > 0 ? point.color : grays_.gray_of_point(points_.intensities, i));
      block_.num_views.push_back(point.num_views);
      block_.best_images.push_back(point.best_image);
      block_.color_spreads.push_back(point.spread);
    }
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
  const MapColors& colors_;
  const GrayScale& grays_;
  PointCloud block_;
  uint32_t begin_ = 0;  // of the block, in map order
};

}  // namespace

void write_colored_map(const std::string& path, const PointMap& points, const MapColors& colors, const GrayScale& grays,
                       const std::string& out) {
  OrderedPoints ordered(path, out, points.map.num_points(), attributes_of(points));
  ColoredBlocks(points, colors, grays).add_to(&ordered);
  write_point_cloud(out, ordered.finish(points.map.origin(), points.las_frame));
}

}  // namespace cpplus
