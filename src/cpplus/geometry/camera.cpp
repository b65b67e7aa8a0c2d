#include "cpplus/geometry/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <type_traits>

#include "cpplus/core/error.h"
#include "cpplus/geometry/camera_models/equirectangular.h"
#include "cpplus/geometry/camera_models/full_opencv.h"
#include "cpplus/geometry/camera_models/opencv.h"
#include "cpplus/geometry/camera_models/opencv_fisheye.h"
#include "cpplus/geometry/camera_models/pinhole.h"
#include "cpplus/geometry/camera_models/radial.h"
#include "cpplus/geometry/camera_models/simple_pinhole.h"
#include "cpplus/geometry/camera_models/simple_radial.h"

namespace cpplus {
namespace {

constexpr CameraModel kAllModels[] = {
    CameraModel::kSimplePinhole, CameraModel::kPinhole,    CameraModel::kSimpleRadial,  CameraModel::kRadial,
    CameraModel::kOpenCv,        CameraModel::kFullOpenCv, CameraModel::kOpenCvFisheye, CameraModel::kEquirectangular,
};

/// function(the struct of the model): resolved at compile time in each branch, so that projections are inlined.
template <typename Function>
auto with_model(CameraModel model, const Function& function) {
  switch (model) {
    case CameraModel::kSimplePinhole:
      return function(camera_models::SimplePinhole{});
    case CameraModel::kPinhole:
      return function(camera_models::Pinhole{});
    case CameraModel::kSimpleRadial:
      return function(camera_models::SimpleRadial{});
    case CameraModel::kRadial:
      return function(camera_models::Radial{});
    case CameraModel::kOpenCv:
      return function(camera_models::OpenCv{});
    case CameraModel::kFullOpenCv:
      return function(camera_models::FullOpenCv{});
    case CameraModel::kOpenCvFisheye:
      return function(camera_models::OpenCvFisheye{});
    case CameraModel::kEquirectangular:
      break;
  }
  return function(camera_models::Equirectangular{});
}

int num_focals(CameraModel model) {
  return with_model(model, [](auto m) { return decltype(m)::kNumFocals; });
}

void check_camera(CameraModel model, int width, int height, const std::vector<double>& params) {
  const std::string name = camera_model_name(model);
  if (width <= 0 || height <= 0)
    throw Error(fmt::format("camera {}: size must be positive, got {}x{}", name, width, height));
  if (params.size() != camera_model_num_params(model)) {
    const char* names = with_model(model, [](auto m) { return decltype(m)::kParams; });
    throw Error(fmt::format("camera {}: expected {} parameters ({}), got {}", name, camera_model_num_params(model),
                            names, params.size()));
  }
  for (size_t i = 0; i < params.size(); ++i) {
    if (!std::isfinite(params[i])) throw Error(fmt::format("camera {}: parameter {} is {}", name, i + 1, params[i]));
  }
  for (int i = 0; i < num_focals(model); ++i) {
    if (params[i] > 0.0) continue;
    const char* what = model == CameraModel::kEquirectangular ? "panorama size" : "focal length";
    throw Error(fmt::format("camera {}: {} must be positive, got {}", name, what, params[i]));
  }
}

}  // namespace

std::optional<CameraModel> camera_model_from_name(const std::string& name) {
  for (const CameraModel model : kAllModels) {
    if (camera_model_name(model) == name) return model;
  }
  return std::nullopt;
}

std::string camera_model_name(CameraModel model) {
  return with_model(model, [](auto m) { return std::string(decltype(m)::kName); });
}

std::optional<CameraModel> camera_model_from_colmap_id(int id) {
  for (const CameraModel model : kAllModels) {
    if (camera_model_colmap_id(model) == id) return model;
  }
  return std::nullopt;
}

int camera_model_colmap_id(CameraModel model) {
  return with_model(model, [](auto m) { return decltype(m)::kColmapId; });
}

size_t camera_model_num_params(CameraModel model) {
  return with_model(model, [](auto m) { return static_cast<size_t>(decltype(m)::kNumParams); });
}

std::vector<std::string> camera_model_param_names(CameraModel model) {
  std::istringstream list(with_model(model, [](auto m) { return std::string(decltype(m)::kParams); }));
  std::vector<std::string> names;
  for (std::string name; std::getline(list >> std::ws, name, ',');) names.push_back(name);
  return names;
}

std::optional<size_t> camera_model_principal_point_index(CameraModel model) {
  if (model == CameraModel::kEquirectangular) return std::nullopt;
  return static_cast<size_t>(num_focals(model));
}

Camera::Camera(CameraModel model, int width, int height, std::vector<double> params)
    : model_(model), width_(width), height_(height), params_(std::move(params)) {
  check_camera(model_, width_, height_, params_);
  max_radius_ = with_model(model_, [this](auto m) { return decltype(m)::max_radius(params_.data()); });
  max_view_angle_ = border_view_angle();
}

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& x_in_camera) const {
  Eigen::Vector2d pixel;
  if (!project(x_in_camera, &pixel, nullptr)) return std::nullopt;
  return pixel;
}

bool Camera::project(const Eigen::Vector3d& x_in_camera, Eigen::Vector2d* pixel,
                     Eigen::Matrix<double, 2, 3>* d_pixel_d_point) const {
  return with_model(model_, [&](auto m) {
    return decltype(m)::project(params_.data(), max_radius_, x_in_camera, pixel, d_pixel_d_point);
  });
}

void Camera::project(size_t count, const float* x, const float* y, const float* z, float* column, float* row) const {
  if (params_.empty()) {
    std::fill_n(column, count, NAN);
    std::fill_n(row, count, NAN);
    return;
  }
  with_model(model_, [&](auto m) {
    using Model = decltype(m);
    if constexpr (std::is_base_of_v<camera_models::PerspectiveModel<Model>, Model>) {
      project_block(Model::coefficients(params_.data(), max_radius_), count, x, y, z, column, row);
    } else {
      for (size_t i = 0; i < count; ++i) {
        Eigen::Vector2d pixel;
        const bool valid = Model::project(params_.data(), max_radius_, {x[i], y[i], z[i]}, &pixel, nullptr);
        column[i] = valid ? static_cast<float>(pixel.x()) : NAN;
        row[i] = valid ? static_cast<float>(pixel.y()) : NAN;
      }
    }
  });
}

std::optional<Eigen::Vector3d> Camera::unproject(const Eigen::Vector2d& pixel) const {
  if (params_.empty()) return std::nullopt;
  return with_model(model_, [&](auto m) { return decltype(m)::unproject(params_.data(), max_radius_, pixel); });
}

double Camera::pixels_per_radian() const {
  switch (model_) {
    case CameraModel::kEquirectangular:
      return params_[0] / (2.0 * M_PI);
    default:
      return 0.5 * (params_[0] + params_[num_focals(model_) - 1]);
  }
}

double Camera::border_view_angle() const {
  if (model_ == CameraModel::kEquirectangular) return M_PI;
  const double limit = model_ == CameraModel::kOpenCvFisheye ? max_radius_ : std::atan(max_radius_);
  constexpr int kSteps = 64;
  double angle = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = (width_ - 1.0) * i / kSteps;
    const double y = (height_ - 1.0) * i / kSteps;
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(x, 0.0), Eigen::Vector2d(x, height_ - 1.0),
                                         Eigen::Vector2d(0.0, y), Eigen::Vector2d(width_ - 1.0, y)}) {
      const std::optional<Eigen::Vector3d> bearing = unproject(pixel);
      if (!bearing) return limit;  // the image reaches beyond the valid range
      angle = std::max(angle, std::atan2(bearing->head<2>().norm(), bearing->z()));
    }
  }
  return angle;
}

}  // namespace cpplus
