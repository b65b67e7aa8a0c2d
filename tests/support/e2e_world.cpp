#include "e2e_world.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cpplus/io/colmap_io.h"
#include "run_cpplus.h"

namespace cpplus {

std::string world_path(const std::string& name) { return std::string(CPPLUS_E2E_WORLD) + "/" + name; }

Rigid3 world_lidar_from_camera(const std::string& world) {
  const nlohmann::json rows = nlohmann::json::parse(read_file(world + "/truth/extrinsic.json")).at("T_lidar_cam");
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = rows[static_cast<size_t>(i / 4)][static_cast<size_t>(i % 4)];
  return Rigid3(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>()), matrix.topRightCorner<3, 1>());
}

std::string write_world_rig(const std::string& file, const Rigid3& camera_from_lidar, const std::string& world) {
  const Camera camera = read_sparse_model(world + "/truth").cameras.begin()->second;
  const Eigen::Quaterniond& q = camera_from_lidar.rotation;
  const Eigen::Vector3d& t = camera_from_lidar.translation;
  write_file(file, fmt::format("cameras:\n  front:\n    model: {}\n    width: {}\n    height: {}\n    params: [{}]\n"
                               "    top_left_pixel: 0\n    camera_from_lidar:\n"
                               "      quaternion_wxyz: [{}, {}, {}, {}]\n      translation: [{}, {}, {}]\n",
                               camera_model_name(camera.model()), camera.width(), camera.height(),
                               fmt::join(camera.params(), ", "), q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()));
  return file;
}

}  // namespace cpplus
