#include "cpplus/report/tile_set.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/pnts.h"
#include "cpplus/report/display_colors.h"
#include "cpplus/report/point_tiles.h"

namespace cpplus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRootSizeM = 64.0;
constexpr double kLeafSizeM = 0.0625;

std::string tile_name(size_t tile) { return fmt::format("tiles/{:06}.pnts", tile); }

Eigen::AlignedBox3d box_of(const std::vector<Eigen::Vector3d>& positions) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : positions) box.extend(x);
  return box;
}

Json box_json(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d center = box.center();
  const Eigen::Vector3d half = (0.5 * box.sizes()).cwiseMax(1e-3);
  return {center.x(), center.y(), center.z(), half.x(), 0, 0, 0, half.y(), 0, 0, 0, half.z()};
}

Json tile_json(const std::vector<PointTile>& tiles, const std::vector<Eigen::AlignedBox3d>& boxes, size_t tile) {
  Json json;
  json["boundingVolume"] = {{"box", box_json(boxes[tile])}};
  json["geometricError"] = tiles[tile].spacing_m;
  json["refine"] = "REPLACE";
  json["content"] = {{"uri", tile_name(tile)}};
  for (uint32_t child : tiles[tile].children) json["children"].push_back(tile_json(tiles, boxes, child));
  return json;
}

}  // namespace

Eigen::Vector3d tile_set_origin(const PointCloud& cloud) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& x : cloud.positions) sum += x.cast<double>();
  return (cloud.origin + sum / static_cast<double>(std::max<size_t>(1, cloud.size()))).array().round();
}

void write_tile_set(const PointCloud& cloud, const Eigen::Vector3d& origin_in_map, const std::string& folder) {
  VoxelMapOptions options;
  options.root_size_m = kRootSizeM;
  options.leaf_size_m = kLeafSizeM;
  const VoxelMap map(cloud, options);
  const DisplayColors colors = display_colors(cloud);
  const std::vector<PointTile> tiles = plan_point_tiles(map, {});
  std::vector<Eigen::AlignedBox3d> boxes(tiles.size());
  Progress progress("write tiles", tiles.size());
  parallel_for_each(tiles.size(), [&](size_t i) {
    const TilePoints points = gather_tile_points(map, tiles[i], colors.colors, colors.is_colored, origin_in_map);
    boxes[i] = box_of(points.positions);
    write_text_file(folder + "/" + tile_name(i), encode_pnts(points.positions, points.colors));
    progress.advance();
  });
  // What finer levels hold may reach beyond the means that a coarse one holds. Children come before parents.
  for (size_t i = 0; i < tiles.size(); ++i) {
    for (uint32_t child : tiles[i].children) boxes[i].extend(boxes[child]);
  }
  Json set;
  set["asset"] = {{"version", "1.0"}};
  set["geometricError"] = tiles.back().size_m;
  set["root"] = tile_json(tiles, boxes, tiles.size() - 1);
  write_text_file(folder + "/tileset.json", set.dump() + "\n");
}

}  // namespace cpplus
