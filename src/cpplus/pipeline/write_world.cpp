#include "cpplus/pipeline/write_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/pipeline/world_files.h"
#include "cpplus/pipeline/write_district.h"

namespace cpplus {
namespace {

void write_labels(const std::string& path, const std::vector<uint8_t>& labels) {
  write_text_file(path, std::string(labels.begin(), labels.end()));
}

void write_scans(const SimulatedWorld& world, const std::string& directory) {
  for (size_t i = 0; i < world.scans.size(); ++i) {
    const SimulatedScan& scan = world.scans[i];
    const std::string name = fmt::format("{}/scans/{:06d}", directory, i);
    write_point_cloud(name + ".pcd", scan.scan.points);
    write_labels(name + ".label", scan.scan.labels);
  }
}

nlohmann::json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

void write_checkerboards(const SimulatedWorld& world, const std::string& directory) {
  constexpr double kDetectableSpacingPx = 5.0;
  constexpr double kColmapOffset = 0.5;
  nlohmann::json boards = nlohmann::json::array();
  for (size_t b = 0; b < world.scene.boards.size(); ++b) {
    const SceneCheckerboard& board = world.scene.boards[b];
    nlohmann::json corners = nlohmann::json::array();
    for (const Eigen::Vector3d& corner : board.corners) corners.push_back(vector_json(corner));
    nlohmann::json images = nlohmann::json::object();
    for (const BoardView& view : world.board_views) {
      if (view.board != b) continue;
      nlohmann::json pixels = nlohmann::json::array();
      for (const Eigen::Vector2d& p : view.corners_px) pixels.push_back({p.x() + kColmapOffset, p.y() + kColmapOffset});
      const SimulatedImage& image = world.images[view.image];
      images[image.name] = {{"corners_2d", pixels},
                            {"min_corner_spacing_px", view.min_spacing_px},
                            {"blurred", image.blur_px > 0.0},
                            {"detectable", image.blur_px == 0.0 && view.min_spacing_px >= kDetectableSpacingPx},
                            {"distance_m", view.distance_m}};
    }
    boards.push_back({{"name", board.name},
                      {"inner_cols", board.inner_columns},
                      {"inner_rows", board.inner_rows},
                      {"square_m", board.square_m},
                      {"corners_3d", corners},
                      {"images", images}});
  }
  const nlohmann::json document = {
      {"pixel_convention", "COLMAP: the centre of the top-left pixel is (0.5, 0.5); subtract 0.5 for OpenCV"},
      {"order", "row-major, as seen from the front: left to right, top to bottom"},
      {"frame", "map, metres"},
      {"boards", boards}};
  write_text_file(directory + "/truth/checkerboards.json", document.dump() + "\n");
}

void write_edges(const SimulatedWorld& world, const std::string& directory) {
  nlohmann::json edges = nlohmann::json::array();
  for (const TrueEdge& edge : world.edges) {
    edges.push_back({{"begin", vector_json(edge.begin)},
                     {"end", vector_json(edge.end)},
                     {"normal_a", vector_json(edge.normal_a)},
                     {"normal_b", vector_json(edge.normal_b)},
                     {"convex", edge.convex},
                     {"objects", {world.scene.objects[edge.object_a], world.scene.objects[edge.object_b]}}});
  }
  const nlohmann::json document = {{"frame", "map, metres; normals point out of the solids"}, {"edges", edges}};
  write_text_file(directory + "/truth/edges.json", document.dump() + "\n");
}

}  // namespace

SimulationSummary write_world(const SimulatedWorld& world, const std::string& directory) {
  write_point_cloud(directory + "/map.pcd", world.map);
  write_labels(directory + "/truth/map.label", world.map_labels);
  write_scans(world, directory);
  write_scan_poses(world, directory);
  parallel_for_each(world.images.size(), [&](size_t i) { write_image(world.images[i], directory); });
  write_image_lists(world, directory);
  write_models(world, directory);
  write_checkerboards(world, directory);
  write_edges(world, directory);
  SimulationSummary summary;
  summary.images = world.images.size();
  summary.scans = world.scans.size();
  summary.map_points = world.map.size();
  summary.moving_map_points = static_cast<size_t>(std::count(world.map_labels.begin(), world.map_labels.end(), 1));
  summary.checkerboards = world.scene.boards.size();
  summary.true_edges = world.edges.size();
  return summary;
}

SimulationSummary simulate(const SimulateOptions& options, const std::string& directory) {
  if (options.is_district()) return write_district(options, directory);
  const AtomicFile probe(directory + "/map.pcd");  // fails before the work rather than after it
  return write_world(simulate_world(options), directory);
}

}  // namespace cpplus
