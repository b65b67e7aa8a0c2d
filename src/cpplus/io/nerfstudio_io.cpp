#include "cpplus/io/nerfstudio_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"

namespace cpplus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTopLeftPixel = 0.5;

void add_intrinsics(const Camera& camera, Json* json) {
  const std::vector<double>& p = camera.params();
  json->update({{"w", camera.width()},
                {"h", camera.height()},
                {"fl_x", p[0]},
                {"fl_y", p[1]},
                {"cx", p[2] + kTopLeftPixel},
                {"cy", p[3] + kTopLeftPixel}});
}

Json transform_matrix(const Rigid3& camera_from_map) {
  const Rigid3 map_from_camera = inverse(camera_from_map);
  const Eigen::Quaterniond camera_from_opengl(0.0, 1.0, 0.0, 0.0);  // half a turn about x
  const Eigen::Matrix3d rotation = (map_from_camera.rotation * camera_from_opengl).toRotationMatrix();
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) {
    rows.push_back({rotation(i, 0), rotation(i, 1), rotation(i, 2), map_from_camera.translation[i]});
  }
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}

bool are_same(const Camera& a, const Camera& b) {
  return a.width() == b.width() && a.height() == b.height() && a.params() == b.params();
}

}  // namespace

void write_nerfstudio(const std::string& path, const std::vector<NerfstudioFrame>& frames,
                      const std::string& ply_path) {
  Json root = {{"camera_model", "PINHOLE"}};
  const bool shared = std::all_of(frames.begin(), frames.end(), [&](const NerfstudioFrame& frame) {
    return are_same(frame.camera, frames.front().camera);
  });
  if (shared && !frames.empty()) add_intrinsics(frames.front().camera, &root);
  if (!ply_path.empty()) root["ply_file_path"] = ply_path;
  root["frames"] = Json::array();
  for (const NerfstudioFrame& frame : frames) {
    if (frame.camera.model() != CameraModel::kPinhole) {
      throw Error(fmt::format("{}: cannot write: the camera of {} is {}, not PINHOLE", path, frame.image_path,
                              camera_model_name(frame.camera.model())));
    }
    Json json = {{"file_path", frame.image_path}};
    if (!frame.depth_path.empty()) json["depth_file_path"] = frame.depth_path;
    if (!shared) add_intrinsics(frame.camera, &json);
    json["transform_matrix"] = transform_matrix(frame.camera_from_map);
    root["frames"].push_back(std::move(json));
  }
  write_text_file(path, root.dump(1) + "\n");
}

}  // namespace cpplus
