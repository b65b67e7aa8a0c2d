#include "cpplus/pipeline/colored_map.h"

#include <array>
#include <vector>

#include "cpplus/core/slot_pipeline.h"
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

/// Blocks of about kBlockPoints points, whole roots, on their way into the order of the input.
constexpr uint32_t kBlockPoints = 1 << 16;
constexpr size_t kSlots = 4;

struct ColoredBlock {
  uint32_t first_root = 0;
  uint32_t end_root = 0;
  PointCloud points;
};

/// The points of a map with their colours, some at a time in map order.
class ColoredBlocks {
 public:
  ColoredBlocks(const PointMap& points, const MapColors& colors, const GrayScale& grays)
      : points_(points), colors_(colors), grays_(grays) {}

  void add_to(OrderedPoints* ordered) {
    std::array<ColoredBlock, kSlots> slots;
    run_slot_pipeline(kSlots, {[&](size_t slot) { return take_roots(&slots[slot]); },
                               [&](size_t slot) { fill(&slots[slot]); },
                               [&](size_t slot) {
                                 ordered->add(slots[slot].points,
                                              points_.map.arrays().input_indices.subspan(first_point(slots[slot]),
                                                                                         num_points(slots[slot])));
                               },
                               {}});
  }

 private:
  uint32_t first_point(const ColoredBlock& block) const { return points_.map.points_begin(0, block.first_root); }
  uint32_t num_points(const ColoredBlock& block) const {
    return points_.map.points_end(0, block.end_root - 1) - first_point(block);
  }

  bool take_roots(ColoredBlock* block) {
    const uint32_t num_roots = points_.map.num_nodes(0);
    if (next_root_ == num_roots) return false;
    block->first_root = next_root_;
    do block->end_root = ++next_root_;
    while (next_root_ < num_roots && num_points(*block) < kBlockPoints);
    return true;
  }

  void fill(ColoredBlock* block) const {
    const VoxelMap& map = points_.map;
    PointCloud& points = block->points;
    const auto assign = [&](const auto& from, auto* to) {
      if (from.empty()) return;
      const auto run = from.subspan(first_point(*block), num_points(*block));
      to->assign(run.begin(), run.end());
    };
    assign(map.positions(), &points.positions);
    assign(points_.intensities, &points.intensities);
    assign(points_.stamps_s, &points.stamps_s);
    points.colors.clear();
    points.num_views.clear();
    points.best_images.clear();
    points.color_spreads.clear();
    for (uint32_t root = block->first_root; root < block->end_root; ++root) {
      add_colors(map.points_begin(0, root), map.points_end(0, root), colors_.of_root(root), &points);
    }
  }

  /// `colored`: of the points [begin, end), or empty.
  void add_colors(uint32_t begin, uint32_t end, const std::vector<ColoredPoint>& colored, PointCloud* points) const {
    for (uint32_t i = begin; i < end; ++i) {
      const ColoredPoint point = colored.empty() ? ColoredPoint{} : colored[i - begin];
      points->colors.push_back(point.num_views > 0 ? point.color : grays_.gray_of_point(points_.intensities, i));
      points->num_views.push_back(point.num_views);
      points->best_images.push_back(point.best_image);
      points->color_spreads.push_back(point.spread);
    }
  }

  const PointMap& points_;
  const MapColors& colors_;
  const GrayScale& grays_;
  uint32_t next_root_ = 0;
};

}  // namespace

void write_colored_map(const std::string& path, const PointMap& points, const MapColors& colors, const GrayScale& grays,
                       const std::string& out) {
  OrderedPoints ordered(path, out, points.map.num_points(), attributes_of(points));
  ColoredBlocks(points, colors, grays).add_to(&ordered);
  write_point_cloud(out, ordered.finish(points.map.origin(), points.las_frame));
}

}  // namespace cpplus
