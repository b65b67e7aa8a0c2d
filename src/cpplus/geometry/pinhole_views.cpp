#include "cpplus/geometry/pinhole_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/core/options.h"

namespace cpplus {
namespace {

constexpr int kMinSidePx = 8;

struct Focals {
  double x = 0.0;
  double y = 0.0;
};

Focals focals_of(const Camera& camera) {
  const size_t num_focals = *camera_model_principal_point_index(camera.model());
  return {camera.params()[0], camera.params()[num_focals - 1]};
}

bool has_no_distortion(const Camera& camera) {
  return camera.model() == CameraModel::kPinhole || camera.model() == CameraModel::kSimplePinhole;
}

Eigen::Vector2d principal_point_of(const Camera& camera) {
  const size_t index = *camera_model_principal_point_index(camera.model());
  return {camera.params()[index], camera.params()[index + 1]};
}

/// How far the image reaches from the optical axis to the left, right, top and bottom (tangents), along the row and the
/// column through the principal point.
struct Reach {
  double left = 0.0, right = 0.0, top = 0.0, bottom = 0.0;

  void scale(double factor) {
    for (double* side : {&left, &right, &top, &bottom}) *side *= factor;
  }
};

Reach reach_of(const Camera& camera, double max_tangent) {
  const Eigen::Vector2d center = principal_point_of(camera);
  const auto tangent_at = [&](const Eigen::Vector2d& pixel) {
    const auto bearing = camera.unproject(pixel);
    if (!bearing || bearing->z() <= 0.0) return max_tangent;
    return std::min(max_tangent, (bearing->head<2>() / bearing->z()).norm());
  };
  Reach reach;
  reach.left = tangent_at({-0.5, center.y()});
  reach.right = tangent_at({camera.width() - 0.5, center.y()});
  reach.top = tangent_at({center.x(), -0.5});
  reach.bottom = tangent_at({center.x(), camera.height() - 0.5});
  return reach;
}

/// Whether every bearing on the border of the rectangle lies in the recorded image.
bool is_inside(const Camera& camera, const Reach& reach) {
  constexpr int kSteps = 200;
  constexpr double kAllowancePx = 0.01;  // the tangents are rounded
  const auto is_seen = [&](double x, double y) {
    const auto pixel = camera.project({x, y, 1.0});
    return pixel && camera.in_image(*pixel, -0.5 - kAllowancePx);
  };
  for (int i = 0; i <= kSteps; ++i) {
    const double share = static_cast<double>(i) / kSteps;
    const double x = -reach.left + share * (reach.left + reach.right);
    const double y = -reach.top + share * (reach.top + reach.bottom);
    if (!is_seen(x, -reach.top) || !is_seen(x, reach.bottom)) return false;
    if (!is_seen(-reach.left, y) || !is_seen(reach.right, y)) return false;
  }
  return true;
}

/// Shrinks the rectangle about the axis until all of it is inside.
void shrink_to_fit(const Camera& camera, Reach* reach) {
  if (is_inside(camera, *reach)) return;
  double fits = 0.0;
  double too_large = 1.0;
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (fits + too_large);
    Reach smaller = *reach;
    smaller.scale(middle);
    (is_inside(camera, smaller) ? fits : too_large) = middle;
  }
  reach->scale(fits);
}

PinholeView undistorted_view(const Camera& camera, const PinholeViewOptions& options) {
  const Focals focals = focals_of(camera);
  Reach reach = reach_of(camera, std::tan(0.5 * options.max_fov_deg * M_PI / 180.0));
  if (options.centered) {
    reach.left = reach.right = std::min(reach.left, reach.right);
    reach.top = reach.bottom = std::min(reach.top, reach.bottom);
  }
  shrink_to_fit(camera, &reach);
  // Whole pixels on each side of the principal point, which thus stays on a border between pixels.
  const auto pixels = [](double tangent, double focal) { return static_cast<int>(std::floor(tangent * focal + 1e-6)); };
  const int left = pixels(reach.left, focals.x);
  const int top = pixels(reach.top, focals.y);
  const int width = left + pixels(reach.right, focals.x);
  const int height = top + pixels(reach.bottom, focals.y);
  if (width < kMinSidePx || height < kMinSidePx) {
    throw Error(fmt::format("camera {} of {}x{}: no undistorted view, only {}x{} pixels would be left",
                            camera_model_name(camera.model()), camera.width(), camera.height(), width, height));
  }
  return {Camera(CameraModel::kPinhole, width, height, {focals.x, focals.y, left - 0.5, top - 0.5}),
          Eigen::Quaterniond::Identity(), ""};
}

std::vector<PinholeView> cube_faces(const Camera& camera) {
  // In the middle of a face a panorama of `width` has width / (2 pi) pixels per radian.
  const int size = 2 * static_cast<int>(std::lround(0.5 * camera.width() / M_PI));
  if (size < kMinSidePx) {
    throw Error(fmt::format("camera EQUIRECTANGULAR of {}x{}: too small for the faces of a cube", camera.width(),
                            camera.height()));
  }
  const Camera face(CameraModel::kPinhole, size, size, {0.5 * size, 0.5 * size, 0.5 * size - 0.5, 0.5 * size - 0.5});
  const auto turned = [](double angle_deg, const Eigen::Vector3d& axis) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle_deg * M_PI / 180.0, axis));
  };
  const Eigen::Vector3d down = Eigen::Vector3d::UnitY();  // of the camera frame, as right is its x axis
  const Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  return {{face, Eigen::Quaterniond::Identity(), "_front"},
          {face, turned(-90, down), "_right"},
          {face, turned(180, down), "_back"},
          {face, turned(90, down), "_left"},
          {face, turned(-90, right), "_up"},
          {face, turned(90, right), "_down"}};
}

}  // namespace

void PinholeViewOptions::validate() const {
  check_option(max_fov_deg > 0 && max_fov_deg <= 170, "max_fov_deg", "(0, 170]", max_fov_deg);
}

std::vector<PinholeView> pinhole_views(const Camera& camera, const PinholeViewOptions& options) {
  options.validate();
  if (camera.model() == CameraModel::kEquirectangular) return cube_faces(camera);
  if (has_no_distortion(camera)) {
    const Eigen::Vector2d middle(0.5 * (camera.width() - 1), 0.5 * (camera.height() - 1));
    const Eigen::Vector2d center = principal_point_of(camera);
    const Focals focals = focals_of(camera);
    if (!options.centered || (center - middle).norm() < 1e-9) {
      return {
          {Camera(CameraModel::kPinhole, camera.width(), camera.height(), {focals.x, focals.y, center.x(), center.y()}),
           Eigen::Quaterniond::Identity(), ""}};
    }
  }
  return {undistorted_view(camera, options)};
}

}  // namespace cpplus
