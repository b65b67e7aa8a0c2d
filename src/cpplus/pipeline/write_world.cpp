#include "cpplus/pipeline/write_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/trajectory_io.h"
#include "cpplus/pipeline/npz_writer.h"

namespace cpplus {
namespace {

constexpr int kJpegQuality = 95;
constexpr int kDepthStep = 4;
constexpr int kDepthOffset = 2;

void write_jpeg(const std::string& path, const ColorImage& image) {
  cv::Mat bgr(image.height, image.width, CV_8UC3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Rgb& pixel = image.at(x, y);
      bgr.at<cv::Vec3b>(y, x) = cv::Vec3b(pixel[2], pixel[1], pixel[0]);
    }
  }
  std::vector<uchar> bytes;
  if (!cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality})) {
    throw Error("cannot encode image: " + path);
  }
  write_text_file(path, std::string(bytes.begin(), bytes.end()));
}

void write_labels(const std::string& path, const std::vector<uint8_t>& labels) {
  write_text_file(path, std::string(labels.begin(), labels.end()));
}

std::string stem(const std::string& name) { return name.substr(0, name.find_last_of('.')); }

void write_images(const SimulatedWorld& world, const std::string& directory) {
  parallel_for_each(world.images.size(), [&](size_t i) {
    const SimulatedImage& image = world.images[i];
    write_jpeg(directory + "/images/" + image.name, image.pixels);
    const std::vector<size_t> shape = {static_cast<size_t>(image.range.height), static_cast<size_t>(image.range.width)};
    write_npz(directory + "/truth/depth/" + stem(image.name) + ".npz",
              {half_array("range", image.range.pixels, shape), int64_scalar("step", kDepthStep),
               int64_scalar("offset", kDepthOffset)});
  });
  std::string stamps;
  std::string blurred;
  std::string moving;
  for (const SimulatedImage& image : world.images) {
    stamps += fmt::format("{} {:.6f}\n", image.name, image.stamp_s);
    if (image.blur_px > 0.0) blurred += image.name + "\n";
    if (image.shows_moving) moving += image.name + "\n";
  }
  write_text_file(directory + "/stamps.txt", stamps);
  write_text_file(directory + "/truth/blurred.txt", blurred);
  write_text_file(directory + "/truth/dynamic_images.txt", moving);
}

void write_scans(const SimulatedWorld& world, const std::string& directory) {
  Trajectory stated;
  Trajectory truth;
  for (size_t i = 0; i < world.scans.size(); ++i) {
    const SimulatedScan& scan = world.scans[i];
    const std::string name = fmt::format("{}/scans/{:06d}", directory, i);
    write_point_cloud(name + ".pcd", scan.scan.points);
    write_labels(name + ".label", scan.scan.labels);
    stated.push_back({scan.stamp_s, scan.map_from_lidar});
    truth.push_back({scan.stamp_s, scan.true_map_from_lidar});
  }
  write_tum(directory + "/scans/poses.txt", stated);
  write_tum(directory + "/truth/scan_poses.txt", truth);
}

void write_models(const SimulatedWorld& world, const std::string& directory) {
  std::vector<Rigid3> truth;
  std::vector<Rigid3> on_map;
  for (const SimulatedImage& image : world.images) {
    truth.push_back(image.camera_from_map);
    on_map.push_back(image.on_map_camera_from_map);
  }
  write_sparse_model_text(directory + "/truth", sparse_model_of(world, truth));
  write_sparse_model_text(directory + "/truth/on_map", sparse_model_of(world, on_map));
  nlohmann::json levels;
  for (const CoarsePoses& level : world.coarse) {
    write_sparse_model_text(directory + "/coarse_" + level.name, sparse_model_of(world, level.camera_from_map));
    levels[level.name] = {{"time_offset_s", level.time_offset_s},
                          {"rms_rot_deg", level.rms_rotation_deg},
                          {"rms_trans_m", level.rms_translation_m}};
  }
  write_text_file(directory + "/truth/coarse_levels.json", levels.dump(1) + "\n");
  const Eigen::Matrix3d rotation = world.lidar_from_camera.rotation.toRotationMatrix();
  nlohmann::json rows = nlohmann::json::array();
  for (int i = 0; i < 3; ++i) {
    rows.push_back({rotation(i, 0), rotation(i, 1), rotation(i, 2), world.lidar_from_camera.translation[i]});
  }
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  write_text_file(directory + "/truth/extrinsic.json", nlohmann::json({{"T_lidar_cam", rows}}).dump(1) + "\n");
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

SparseModel sparse_model_of(const SimulatedWorld& world, const std::vector<Rigid3>& camera_from_map) {
  SparseModel model;
  model.cameras[1] = world.camera;
  for (size_t i = 0; i < world.images.size(); ++i) {
    model.images.push_back({static_cast<uint32_t>(i + 1), world.images[i].name, 1, camera_from_map[i]});
  }
  return model;
}

SimulationSummary write_world(const SimulatedWorld& world, const std::string& directory) {
  write_point_cloud(directory + "/map.pcd", world.map);
  write_labels(directory + "/truth/map.label", world.map_labels);
  write_scans(world, directory);
  write_images(world, directory);
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
  return write_world(simulate_world(options), directory);
}

}  // namespace cpplus
