#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <tuple>

#include "cpplus/core/error.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/import_files.h"
#include "cpplus/io/imported_project.h"
#include "cpplus/io/rotation_check.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kTopLeftPixel = 0.5;  // nerfstudio keeps COLMAP's principal points

Json load(const std::string& path) {
  std::ifstream stream(path);
  if (!stream) throw Error(fmt::format("{}: cannot be read", path));
  try {
    return Json::parse(stream);
  } catch (const Json::exception& error) {
    throw Error(fmt::format("{}: {}", path, error.what()));
  }
}

/// A value of the frame, or else of the whole file.
class FrameFields {
 public:
  FrameFields(const Json& root, const Json& frame, std::string where)
      : root_(root), frame_(frame), where_(std::move(where)) {}

  const Json* find(const char* key) const {
    if (frame_.contains(key)) return &frame_[key];
    return root_.contains(key) ? &root_[key] : nullptr;
  }

  double number_or(const char* key, double fallback) const {
    const Json* value = find(key);
    if (!value) return fallback;
    if (!value->is_number()) throw Error(fmt::format("{}: {} is not a number: {}", where_, key, value->dump()));
    return value->get<double>();
  }

  double number(const char* key) const {
    if (!find(key)) throw Error(fmt::format("{}: has no {}", where_, key));
    return number_or(key, 0.0);
  }

  std::string text_or(const char* key, const std::string& fallback) const {
    const Json* value = find(key);
    if (!value) return fallback;
    if (!value->is_string()) throw Error(fmt::format("{}: {} is not text: {}", where_, key, value->dump()));
    return value->get<std::string>();
  }

  const std::string& where() const { return where_; }

 private:
  const Json& root_;
  const Json& frame_;
  std::string where_;
};

/// camera_model, parameters in COLMAP's pixels.
std::pair<CameraModel, std::vector<double>> model_and_params(const FrameFields& fields, double width, double height) {
  // Blender's files give the horizontal angle of view alone.
  const double from_angle =
      fields.find("camera_angle_x") ? 0.5 * width / std::tan(0.5 * fields.number("camera_angle_x")) : 0.0;
  const double fx = from_angle > 0.0 ? fields.number_or("fl_x", from_angle) : fields.number("fl_x");
  const double fy = fields.number_or("fl_y", fx);
  const std::vector<double> focal = {fx, fy, fields.number_or("cx", 0.5 * width), fields.number_or("cy", 0.5 * height)};
  const auto value = [&](const char* key) { return fields.number_or(key, 0.0); };
  const auto with = [&](std::initializer_list<double> distortion) {
    std::vector<double> params = focal;
    params.insert(params.end(), distortion);
    return params;
  };
  const std::string name = fields.text_or("camera_model", "OPENCV");
  if (name == "OPENCV_FISHEYE")
    return {CameraModel::kOpenCvFisheye, with({value("k1"), value("k2"), value("k3"), value("k4")})};
  if (name != "OPENCV" && name != "PINHOLE" && name != "SIMPLE_PINHOLE") {
    throw Error(
        fmt::format("{}: unknown camera_model '{}': known are OPENCV, OPENCV_FISHEYE, PINHOLE and SIMPLE_PINHOLE",
                    fields.where(), name));
  }
  if (value("k4") != 0.0)
    throw Error(fmt::format("{}: k4 of the model OPENCV is not known, got {}", fields.where(), value("k4")));
  if (value("k3") != 0.0) {
    return {CameraModel::kFullOpenCv,
            with({value("k1"), value("k2"), value("p1"), value("p2"), value("k3"), 0.0, 0.0, 0.0})};
  }
  const bool has_distortion = value("k1") != 0.0 || value("k2") != 0.0 || value("p1") != 0.0 || value("p2") != 0.0;
  if (!has_distortion) return {CameraModel::kPinhole, focal};
  return {CameraModel::kOpenCv, with({value("k1"), value("k2"), value("p1"), value("p2")})};
}

Camera camera_of(const FrameFields& fields, const std::string& image) {
  ImageSize size;
  if (fields.find("w") && fields.find("h")) {
    size = {static_cast<int>(fields.number("w")), static_cast<int>(fields.number("h"))};
  } else {
    size = read_image_size(image);
  }
  auto [model, params] = model_and_params(fields, size.width, size.height);
  for (const size_t i : {2, 3}) params[i] -= kTopLeftPixel;
  try {
    return Camera(model, size.width, size.height, params);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", fields.where(), error.what()));
  }
}

/// transform_matrix is map_from_camera of a camera with x right, y up and z backward.
Rigid3 camera_from_map(const FrameFields& fields) {
  const Json* matrix = fields.find("transform_matrix");
  const bool has_rows = matrix && matrix->is_array() && (matrix->size() == 3 || matrix->size() == 4);
  Eigen::Matrix<double, 3, 4> map_from_camera;
  for (size_t row = 0; row < 3; ++row) {
    if (!has_rows || !(*matrix)[row].is_array() || (*matrix)[row].size() != 4) {
      throw Error(fmt::format("{}: transform_matrix is not a 4x4 matrix", fields.where()));
    }
    for (size_t column = 0; column < 4; ++column) {
      const Json& value = (*matrix)[row][column];
      if (!value.is_number()) throw Error(fmt::format("{}: transform_matrix holds {}", fields.where(), value.dump()));
      map_from_camera(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) = value.get<double>();
    }
  }
  const Eigen::Quaterniond map_from_opengl =
      checked_rotation(fields.where(), Eigen::Matrix3d(map_from_camera.leftCols<3>()));
  const Eigen::Quaterniond opengl_from_camera(0.0, 1.0, 0.0, 0.0);  // half a turn about x
  return inverse(Rigid3(map_from_opengl * opengl_from_camera, map_from_camera.col(3)));
}

/// The image's file; Blender leaves ".png" away.
fs::path image_file(const fs::path& folder, const std::string& file_path) {
  const fs::path path = folder / file_path;
  return path.has_extension() || fs::exists(path) ? path : fs::path(path.string() + ".png");
}

/// "./images/left/a.png" -> "left/a.png": inside the folder images of a project.
std::string project_name(const fs::path& file_path) {
  fs::path name;
  for (const fs::path& part : file_path.is_absolute() ? file_path.filename() : file_path.lexically_normal()) {
    if (part != ".." && part != "." && !(name.empty() && part == "images")) name /= part;
  }
  return name.generic_string();
}

using CameraKey = std::tuple<int, int, int, std::vector<double>>;

}  // namespace

ImportedProject import_nerfstudio(const std::string& path) {
  const std::string file = fs::is_directory(path) ? required_file(path, "transforms.json") : path;
  const fs::path folder = fs::path(file).parent_path();
  const Json root = load(file);
  if (!root.is_object() || !root.contains("frames") || !root["frames"].is_array() || root["frames"].empty()) {
    throw Error(fmt::format("{}: has no frames", file));
  }
  ImportedProject project;
  project.model.emplace();
  std::map<CameraKey, uint32_t> camera_ids;
  size_t num_missing = 0;
  for (size_t i = 0; i < root["frames"].size(); ++i) {
    const FrameFields fields(root, root["frames"][i], fmt::format("{}: frame {}", file, i));
    const std::string file_path = fields.text_or("file_path", "");
    if (file_path.empty()) throw Error(fmt::format("{}: has no file_path", fields.where()));
    const fs::path image = image_file(folder, file_path);
    if (!fs::exists(image)) {
      ++num_missing;
      continue;
    }
    const Camera camera = camera_of(fields, image.string());
    const CameraKey key{static_cast<int>(camera.model()), camera.width(), camera.height(), camera.params()};
    const auto [entry, is_new] = camera_ids.emplace(key, static_cast<uint32_t>(camera_ids.size() + 1));
    if (is_new) project.model->cameras.emplace(entry->second, camera);
    const fs::path relative = file_path + (image.extension() == fs::path(file_path).extension() ? "" : ".png");
    const std::string name = project_name(relative);
    project.images.push_back({image.string(), name});
    project.model->images.push_back({static_cast<uint32_t>(i + 1), name, entry->second, camera_from_map(fields)});
  }
  if (project.images.empty())
    throw Error(fmt::format("{}: none of its {} images is there", file, root["frames"].size()));
  if (num_missing > 0)
    project.notes.push_back(fmt::format("{}: {} of {} images missing", file, num_missing, root["frames"].size()));
  if (root.contains("ply_file_path") && root["ply_file_path"].is_string()) {
    project.map = first_file(folder.string(), {root["ply_file_path"].get<std::string>()});
  }
  return project;
}

}  // namespace cpplus
