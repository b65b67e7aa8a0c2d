#include "cpplus/io/rig_formats.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "cpplus/core/error.h"
#include "cpplus/io/rig_io.h"
#include "cpplus/io/yaml_fields.h"

namespace cpplus {
namespace {

Camera make_camera(const std::string& where, CameraModel model, int width, int height, std::vector<double> params) {
  try {
    return Camera(model, width, height, std::move(params));
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", where, error.what()));
  }
}

std::vector<double> joined(std::vector<double> first, const std::vector<double>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

std::vector<double> focal_of_matrix(const YAML::Node& node, const std::string& where) {
  const std::vector<double> k = yaml_numbers(node, where);
  if (k.size() != 9) throw Error(fmt::format("{}: a camera matrix has 9 numbers, this has {}", where, k.size()));
  return {k[0], k[4], k[2], k[5]};
}

}  // namespace

Camera opencv_camera(const std::string& where, int width, int height, const std::vector<double>& focal,
                     std::vector<double> distortion) {
  if (focal.size() != 4) throw Error(fmt::format("{}: {} numbers instead of fx fy cx cy", where, focal.size()));
  while (!distortion.empty() && distortion.back() == 0.0) distortion.pop_back();
  if (distortion.empty()) return make_camera(where, CameraModel::kPinhole, width, height, focal);
  const bool has_higher = distortion.size() > 4;
  if (distortion.size() > 8) {
    throw Error(fmt::format("{}: {} distortion coefficients, at most k1 k2 p1 p2 k3 k4 k5 k6 are known", where,
                            distortion.size()));
  }
  distortion.resize(has_higher ? 8 : 4, 0.0);
  return make_camera(where, has_higher ? CameraModel::kFullOpenCv : CameraModel::kOpenCv, width, height,
                     joined(focal, distortion));
}

Camera fisheye_camera(const std::string& where, int width, int height, const std::vector<double>& focal,
                      const std::vector<double>& distortion) {
  return make_camera(where, CameraModel::kOpenCvFisheye, width, height, joined(focal, distortion));
}

YAML::Node ros_parameters(const YAML::Node& root) {
  if (root.size() != 1) return root;
  const YAML::Node inner = root.begin()->second;
  return inner.IsMap() && inner["ros__parameters"] ? inner["ros__parameters"] : root;
}

Camera ros_camera_info(const YAML::Node& root, const std::string& path) {
  const int width = yaml_int(yaml_child(root, "image_width", path), path + ": image_width");
  const int height = yaml_int(yaml_child(root, "image_height", path), path + ": image_height");
  const YAML::Node matrix = yaml_child(yaml_child(root, "camera_matrix", path), "data", path + ": camera_matrix");
  const std::string model = yaml_text(yaml_child(root, "distortion_model", path), path + ": distortion_model");
  const std::string where = path + ": distortion_coefficients";
  const YAML::Node distortion = yaml_child(yaml_child(root, "distortion_coefficients", path), "data", where);
  return ros_camera(path, width, height, model, yaml_numbers(matrix, path + ": camera_matrix"),
                    yaml_numbers(distortion, where));
}

Camera ros_camera(const std::string& where, int width, int height, const std::string& distortion_model,
                  const std::vector<double>& matrix, const std::vector<double>& distortion) {
  if (matrix.size() != 9)
    throw Error(fmt::format("{}: a camera matrix has 9 numbers, this has {}", where, matrix.size()));
  const std::vector<double> focal = {matrix[0], matrix[4], matrix[2], matrix[5]};
  if (distortion_model == "plumb_bob" || distortion_model == "rational_polynomial") {
    return opencv_camera(where, width, height, focal, distortion);
  }
  if (distortion_model == "equidistant" || distortion_model == "fisheye") {
    return fisheye_camera(where, width, height, focal, distortion);
  }
  throw Error(fmt::format(
      "{}: unknown distortion_model '{}': known are plumb_bob, rational_polynomial, equidistant and fisheye", where,
      distortion_model));
}

Camera kalibr_camera(const YAML::Node& node, const std::string& where) {
  const std::string projection = yaml_text(yaml_child(node, "camera_model", where), where + ".camera_model");
  if (projection != "pinhole") {
    throw Error(fmt::format("{}: unknown camera_model '{}': known is pinhole", where, projection));
  }
  const std::vector<double> size = yaml_numbers(yaml_child(node, "resolution", where), where + ".resolution");
  if (size.size() != 2)
    throw Error(fmt::format("{}.resolution: {} numbers instead of width and height", where, size.size()));
  const int width = static_cast<int>(size[0]);
  const int height = static_cast<int>(size[1]);
  const std::vector<double> focal = yaml_numbers(yaml_child(node, "intrinsics", where), where + ".intrinsics");
  const std::string model = yaml_text(yaml_child(node, "distortion_model", where), where + ".distortion_model");
  if (model == "none") return opencv_camera(where, width, height, focal, {});
  const std::vector<double> distortion =
      yaml_numbers(yaml_child(node, "distortion_coeffs", where), where + ".distortion_coeffs");
  if (model == "radtan") return opencv_camera(where, width, height, focal, distortion);
  if (model == "equidistant") return fisheye_camera(where, width, height, focal, distortion);
  throw Error(fmt::format("{}: unknown distortion_model '{}': known are radtan, equidistant and none", where, model));
}

Rig kalibr_rig(const YAML::Node& root, const std::string& path) {
  Rig rig;
  rig.trajectory_frame = RigFrame::kBody;
  for (int i = 0; root["cam" + std::to_string(i)]; ++i) {
    RigCamera camera;
    camera.name = "cam" + std::to_string(i);
    const YAML::Node node = root[camera.name];
    const std::string where = fmt::format("{}: {}", path, camera.name);
    camera.camera = kalibr_camera(node, where);
    camera.time_offset_s = yaml_number_or(node, "timeshift_cam_imu", 0.0, where);
    if (node["T_cam_imu"]) {
      camera.camera_from_body = yaml_matrix(node["T_cam_imu"], where + ".T_cam_imu");
    } else if (i > 0 && node["T_cn_cnm1"]) {
      // A chain of cameras: this one from the one before.
      camera.camera_from_body =
          yaml_matrix(node["T_cn_cnm1"], where + ".T_cn_cnm1") * *rig.cameras.back().camera_from_body;
    } else {
      throw Error(fmt::format("{}: has no T_cam_imu", where));
    }
    rig.cameras.push_back(std::move(camera));
  }
  return rig;
}

Rig r3live_rig(const YAML::Node& root, const std::string& path) {
  const std::string where = path + ": r3live_vio";
  const YAML::Node vio = root["r3live_vio"];
  RigCamera camera;
  camera.name = "camera";
  const YAML::Node matrix = yaml_child(vio, "camera_intrinsic", where);
  camera.camera =
      opencv_camera(where, yaml_int(yaml_child(vio, "image_width", where), where + ".image_width"),
                    yaml_int(yaml_child(vio, "image_height", where), where + ".image_height"),
                    focal_of_matrix(matrix, where + ".camera_intrinsic"),
                    yaml_numbers(yaml_child(vio, "camera_dist_coeffs", where), where + ".camera_dist_coeffs"));
  const Rigid3 body_from_camera = yaml_rotation_translation(
      yaml_child(vio, "camera_ext_R", where), yaml_child(vio, "camera_ext_t", where), where + ".camera_ext_R");
  camera.camera_from_body = inverse(body_from_camera);
  return {{camera}, RigFrame::kBody};
}

bool is_fast_livo2_camera(const YAML::Node& root) {
  const YAML::Node parameters = ros_parameters(root);
  const YAML::Node camera = parameters["camera"].IsDefined() ? parameters["camera"] : parameters;
  return camera.IsMap() && (camera["cam_fx"] || camera["fx"]);
}

Camera fast_livo2_camera(const YAML::Node& root, const std::string& path) {
  const YAML::Node parameters = ros_parameters(root);
  const YAML::Node node = parameters["camera"].IsDefined() ? parameters["camera"] : parameters;
  const std::string prefix = node["cam_fx"] ? "cam_" : "";
  const auto number = [&](const std::string& key) {
    return yaml_number(yaml_child(node, key, path), path + ": " + key);
  };
  const auto size = [&](const std::string& key) { return yaml_int(yaml_child(node, key, path), path + ": " + key); };
  const int width = size(prefix + "width");
  const int height = size(prefix + "height");
  const std::vector<double> focal = {number(prefix + "fx"), number(prefix + "fy"), number(prefix + "cx"),
                                     number(prefix + "cy")};
  const std::string model = yaml_text(yaml_child(node, prefix + "model", path), path + ": " + prefix + "model");
  if (model == "Pinhole") {
    std::vector<double> distortion;
    for (const char* key : {"d0", "d1", "d2", "d3"}) {
      distortion.push_back(yaml_number_or(node, prefix + key, 0.0, path));
    }
    return opencv_camera(path, width, height, focal, distortion);
  }
  if (model == "EquidistantCamera") {
    return fisheye_camera(path, width, height, focal, {number("k1"), number("k2"), number("k3"), number("k4")});
  }
  throw Error(fmt::format("{}: unknown {}model '{}': known are Pinhole and EquidistantCamera", path, prefix, model));
}

Rig fast_livo2_rig(const YAML::Node& root, const std::string& path, const std::string& intrinsics) {
  const YAML::Node parameters = ros_parameters(root);
  const std::string where = path + ": extrin_calib";
  const YAML::Node calib = parameters["extrin_calib"];
  RigCamera camera;
  camera.name = "camera";
  if (!intrinsics.empty()) {
    camera.camera = read_intrinsics(intrinsics);
  } else if (is_fast_livo2_camera(root)) {
    camera.camera = fast_livo2_camera(root, path);
  } else {
    throw Error(
        fmt::format("{}: holds no camera; FAST-LIVO2 keeps it in a file of its own, to be given as intrinsics", path));
  }
  const Rigid3 body_from_lidar = yaml_rotation_translation(
      yaml_child(calib, "extrinsic_R", where), yaml_child(calib, "extrinsic_T", where), where + ".extrinsic_R");
  camera.camera_from_lidar =
      yaml_rotation_translation(yaml_child(calib, "Rcl", where), yaml_child(calib, "Pcl", where), where + ".Rcl");
  camera.camera_from_body = *camera.camera_from_lidar * inverse(body_from_lidar);
  if (const YAML::Node offset = parameters["time_offset"]; offset && offset.IsMap()) {
    camera.time_offset_s = yaml_number_or(offset, "img_time_offset", 0.0, path + ": time_offset") +
                           yaml_number_or(offset, "exposure_time_init", 0.0, path + ": time_offset");
  }
  return {{camera}, RigFrame::kBody};
}

}  // namespace cpplus
