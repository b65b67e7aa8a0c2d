#include "cpplus/io/rig_io.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <sstream>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/colmap_model.h"
#include "cpplus/io/rig_formats.h"
#include "cpplus/io/rotation_check.h"
#include "cpplus/io/yaml_fields.h"

namespace cpplus {
namespace {

constexpr double kColmapPixel = 0.5;  // COLMAP's coordinate of the centre of the top-left pixel

/// A transform of our own format: matrix, or quaternion_wxyz or quaternion_xyzw with translation.
Rigid3 own_transform(const YAML::Node& node, const std::string& where) {
  check_yaml_keys(node, {"matrix", "quaternion_wxyz", "quaternion_xyzw", "translation"}, where);
  const bool has_wxyz = node["quaternion_wxyz"].IsDefined();
  const bool has_xyzw = node["quaternion_xyzw"].IsDefined();
  if (static_cast<int>(node["matrix"].IsDefined()) + has_wxyz + has_xyzw != 1) {
    throw Error(fmt::format("{}: takes one of matrix, quaternion_wxyz and quaternion_xyzw", where));
  }
  if (node["matrix"]) return yaml_matrix(node["matrix"], where + ".matrix");
  const std::vector<double> q = yaml_numbers(node[has_wxyz ? "quaternion_wxyz" : "quaternion_xyzw"], where);
  const std::vector<double> t = yaml_numbers(yaml_child(node, "translation", where), where + ".translation");
  if (q.size() != 4 || t.size() != 3) {
    throw Error(fmt::format("{}: {} and {} numbers instead of the 4 of a quaternion and the 3 of a translation", where,
                            q.size(), t.size()));
  }
  const Eigen::Quaterniond rotation =
      has_wxyz ? Eigen::Quaterniond(q[0], q[1], q[2], q[3]) : Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
  return Rigid3(checked_rotation(where, rotation), Eigen::Vector3d(t[0], t[1], t[2]));
}

Camera own_camera_model(const YAML::Node& node, const std::string& path, const std::string& where) {
  if (node["intrinsics"]) {
    const std::string file = yaml_text(node["intrinsics"], where + ".intrinsics");
    return read_intrinsics((std::filesystem::path(path).parent_path() / file).string());
  }
  const std::string name = yaml_text(yaml_child(node, "model", where), where + ".model");
  const std::optional<CameraModel> model = camera_model_from_name(name);
  if (!model) throw Error(fmt::format("{}: unknown camera model '{}'", where, name));
  std::vector<double> params = yaml_numbers(yaml_child(node, "params", where), where + ".params");
  const double top_left = yaml_number_or(node, "top_left_pixel", kColmapPixel, where);
  if (top_left != 0.0 && top_left != kColmapPixel) {
    throw Error(fmt::format("{}.top_left_pixel: must be 0.5 (COLMAP) or 0 (OpenCV), got {}", where, top_left));
  }
  if (params.size() == camera_model_num_params(*model)) shift_principal_point(*model, -top_left, &params);
  try {
    return Camera(*model, yaml_int(yaml_child(node, "width", where), where + ".width"),
                  yaml_int(yaml_child(node, "height", where), where + ".height"), params);
  } catch (const Error& error) {
    if (std::string(error.what()).starts_with(where)) throw;
    throw Error(fmt::format("{}: {}", where, error.what()));
  }
}

RigCamera own_camera(const YAML::Node& node, const std::string& name, const std::string& path,
                     const std::optional<Rigid3>& body_from_lidar) {
  const std::string where = fmt::format("{}: cameras.{}", path, name);
  check_yaml_keys(node,
                  {"model", "width", "height", "params", "top_left_pixel", "intrinsics", "images", "camera_from_lidar",
                   "camera_from_body", "time_offset_s", "readout_s"},
                  where);
  RigCamera camera;
  camera.name = name;
  camera.camera = own_camera_model(node, path, where);
  if (node["images"]) camera.image_prefix = yaml_text(node["images"], where + ".images");
  if (node["camera_from_lidar"])
    camera.camera_from_lidar = own_transform(node["camera_from_lidar"], where + ".camera_from_lidar");
  if (node["camera_from_body"])
    camera.camera_from_body = own_transform(node["camera_from_body"], where + ".camera_from_body");
  if (!camera.camera_from_lidar && !camera.camera_from_body) {
    throw Error(fmt::format("{}: has neither camera_from_lidar nor camera_from_body", where));
  }
  if (body_from_lidar && !camera.camera_from_body)
    camera.camera_from_body = *camera.camera_from_lidar * inverse(*body_from_lidar);
  if (body_from_lidar && !camera.camera_from_lidar)
    camera.camera_from_lidar = *camera.camera_from_body * *body_from_lidar;
  camera.time_offset_s = yaml_number_or(node, "time_offset_s", 0.0, where);
  camera.readout_s = yaml_number_or(node, "readout_s", 0.0, where);
  if (camera.readout_s < 0.0)
    throw Error(fmt::format("{}.readout_s: must not be negative, got {}", where, camera.readout_s));
  return camera;
}

Rig read_any_rig(const std::string& path, const std::string& intrinsics) {
  const YAML::Node root = load_yaml_map(path);
  if (ros_parameters(root)["extrin_calib"]) return fast_livo2_rig(root, path, intrinsics);
  if (!intrinsics.empty()) {
    throw Error(fmt::format("{}: only a FAST-LIVO2 file takes its intrinsics from another ({})", path, intrinsics));
  }
  if (root["cameras"]) return own_rig(root, path);
  if (root["cam0"]) return kalibr_rig(root, path);
  if (root["r3live_vio"]) return r3live_rig(root, path);
  if (root["camera_matrix"]) {
    throw Error(fmt::format(
        "{}: a camera_info file has no extrinsic; name it as `intrinsics` of a camera in a rig file", path));
  }
  throw Error(fmt::format("{}: not a rig: none of the keys cameras, cam0, r3live_vio and extrin_calib", path));
}

std::string number_list(const std::vector<double>& numbers) { return fmt::format("[{}]", fmt::join(numbers, ", ")); }

std::string transform_yaml(const char* key, const std::optional<Rigid3>& transform) {
  if (!transform) return "";
  const Eigen::Quaterniond& q = transform->rotation;
  const Eigen::Vector3d& t = transform->translation;
  return fmt::format("    {}:\n      quaternion_wxyz: {}\n      translation: {}\n", key,
                     number_list({q.w(), q.x(), q.y(), q.z()}), number_list({t.x(), t.y(), t.z()}));
}

}  // namespace

Rig own_rig(const YAML::Node& root, const std::string& path) {
  check_yaml_keys(root, {"trajectory_frame", "body_from_lidar", "cameras"}, path);
  Rig rig;
  if (root["trajectory_frame"]) {
    const std::string frame = yaml_text(root["trajectory_frame"], path + ": trajectory_frame");
    if (frame != "lidar" && frame != "body") {
      throw Error(fmt::format("{}: trajectory_frame must be lidar or body, got '{}'", path, frame));
    }
    rig.trajectory_frame = frame == "body" ? RigFrame::kBody : RigFrame::kLidar;
  }
  std::optional<Rigid3> body_from_lidar;
  if (root["body_from_lidar"]) body_from_lidar = own_transform(root["body_from_lidar"], path + ": body_from_lidar");
  const YAML::Node cameras = root["cameras"];
  if (!cameras.IsMap() || cameras.size() == 0)
    throw Error(fmt::format("{}: cameras must be a group with a key a camera", path));
  for (const auto& entry : cameras) {
    rig.cameras.push_back(own_camera(entry.second, yaml_text(entry.first, path + ": cameras"), path, body_from_lidar));
  }
  return rig;
}

Rig read_rig(const std::string& path, const std::string& intrinsics) {
  Rig rig = read_any_rig(path, intrinsics);
  if (rig.cameras.size() > 1) {
    for (RigCamera& camera : rig.cameras) {
      if (camera.image_prefix.empty()) camera.image_prefix = camera.name + "/";
    }
  }
  return rig;
}

Camera read_intrinsics(const std::string& path) {
  const YAML::Node root = load_yaml_map(path);
  if (root["camera_matrix"]) return ros_camera_info(root, path);
  if (is_fast_livo2_camera(root)) return fast_livo2_camera(root, path);
  if (root["cam0"] && !root["cam1"]) return kalibr_camera(root["cam0"], path + ": cam0");
  throw Error(
      fmt::format("{}: not a camera: neither ROS camera_info, FAST-LIVO2 nor a Kalibr file of one camera", path));
}

void write_rig(const std::string& path, const Rig& rig) {
  std::string text =
      fmt::format("trajectory_frame: {}\ncameras:\n", rig.trajectory_frame == RigFrame::kBody ? "body" : "lidar");
  for (const RigCamera& camera : rig.cameras) {
    std::vector<double> params = camera.camera.params();
    shift_principal_point(camera.camera.model(), kColmapPixel, &params);
    YAML::Emitter name;
    name << camera.name;
    YAML::Emitter prefix;
    prefix << YAML::DoubleQuoted << camera.image_prefix;
    text += fmt::format("  {}:\n    model: {}\n    width: {}\n    height: {}\n    params: {}\n    images: {}\n",
                        name.c_str(), camera_model_name(camera.camera.model()), camera.camera.width(),
                        camera.camera.height(), number_list(params), prefix.c_str());
    text += transform_yaml("camera_from_lidar", camera.camera_from_lidar);
    text += transform_yaml("camera_from_body", camera.camera_from_body);
    text += fmt::format("    time_offset_s: {}\n    readout_s: {}\n", camera.time_offset_s, camera.readout_s);
  }
  write_text_file(path, text);
}

}  // namespace cpplus
