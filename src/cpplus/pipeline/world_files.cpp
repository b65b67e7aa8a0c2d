#include "cpplus/pipeline/world_files.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/colmap_io.h"
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

std::string stem(const std::string& name) { return name.substr(0, name.find_last_of('.')); }

}  // namespace

void write_image(const SimulatedImage& image, const std::string& directory) {
  write_jpeg(directory + "/images/" + image.name, image.pixels);
  const std::vector<size_t> shape = {static_cast<size_t>(image.range.height), static_cast<size_t>(image.range.width)};
  write_npz(directory + "/truth/depth/" + stem(image.name) + ".npz",
            {half_array("range", image.range.pixels, shape), int64_scalar("step", kDepthStep),
             int64_scalar("offset", kDepthOffset)});
}

void write_image_lists(const SimulatedWorld& world, const std::string& directory) {
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

void write_scan_poses(const SimulatedWorld& world, const std::string& directory) {
  Trajectory stated;
  Trajectory truth;
  for (const SimulatedScan& scan : world.scans) {
    stated.push_back({scan.stamp_s, scan.map_from_lidar});
    truth.push_back({scan.stamp_s, scan.true_map_from_lidar});
  }
  write_tum(directory + "/scans/poses.txt", stated);
  write_tum(directory + "/truth/scan_poses.txt", truth);
}

SparseModel sparse_model_of(const SimulatedWorld& world, const std::vector<Rigid3>& camera_from_map) {
  SparseModel model;
  model.cameras[1] = world.camera;
  for (size_t i = 0; i < world.images.size(); ++i) {
    model.images.push_back({static_cast<uint32_t>(i + 1), world.images[i].name, 1, camera_from_map[i]});
  }
  return model;
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

}  // namespace cpplus
