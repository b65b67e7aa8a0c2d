#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace cpplus {

/// Camera models with COLMAP's names, parameter order and formulas.
enum class CameraModel {
  kSimplePinhole,
  kPinhole,
  kSimpleRadial,
  kRadial,
  kOpenCv,
  kFullOpenCv,
  kOpenCvFisheye,
  kEquirectangular,
};

/// "OPENCV" -> kOpenCv; nothing for a name that is not known.
std::optional<CameraModel> camera_model_from_name(const std::string& name);
std::string camera_model_name(CameraModel model);
/// COLMAP's numeric id in cameras.bin; nothing for an id that is not known.
std::optional<CameraModel> camera_model_from_colmap_id(int id);
int camera_model_colmap_id(CameraModel model);
size_t camera_model_num_params(CameraModel model);
/// "fx, fy, cx, cy, k1, k2, p1, p2": their names in order.
std::vector<std::string> camera_model_param_names(CameraModel model);
/// Index of cx in the parameters (cy follows): what a change of the pixel convention shifts. Nothing for
/// EQUIRECTANGULAR.
std::optional<size_t> camera_model_principal_point_index(CameraModel model);

/// An intrinsically calibrated camera. Pixels: the centre of the top-left pixel is (0, 0); a principal point in
/// `params` is in the same convention (COLMAP files have it 0.5 larger; io/ converts). Each model's equations and range
/// of validity stand in its header in camera_models/.
class Camera {
 public:
  Camera() = default;
  /// Throws Error for a wrong number of parameters, NaN, non-positive size or focal length.
  Camera(CameraModel model, int width, int height, std::vector<double> params);

  CameraModel model() const { return model_; }
  int width() const { return width_; }
  int height() const { return height_; }
  const std::vector<double>& params() const { return params_; }

  /// Pixel of a point in the camera frame (x right, y down, z forward; metres), also when it falls outside the image.
  /// Nothing where the model does not hold: behind the camera, or beyond the monotonic range of the distortion.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera) const;

  /// The same, with the 2x3 Jacobian d pixel / d x_in_camera (pixel/m; may be null). False where project() gives
  /// nothing.
  bool project(const Eigen::Vector3d& x_in_camera, Eigen::Vector2d* pixel,
               Eigen::Matrix<double, 2, 3>* d_pixel_d_point) const;

  /// The same for many points at once, one array a coordinate; NaN where project() gives nothing. In single precision,
  /// to about 1e-3 pixels.
  void project(size_t count, const float* x, const float* y, const float* z, float* column, float* row) const;

  /// Unit bearing in the camera frame of a pixel; nothing where no bearing projects there.
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel) const;

  /// Pixel inside [margin, size-1-margin].
  bool in_image(const Eigen::Vector2d& pixel, double margin_px = 0.0) const {
    return pixel.x() >= margin_px && pixel.y() >= margin_px && pixel.x() <= width_ - 1 - margin_px &&
           pixel.y() <= height_ - 1 - margin_px;
  }

  /// Pixels per radian at the principal point (the mean focal length; width / 2 pi for EQUIRECTANGULAR).
  double pixels_per_radian() const;

  /// Largest angle between the optical axis and the bearing of any pixel of the image, rad (pi for EQUIRECTANGULAR).
  double max_view_angle() const { return max_view_angle_; }

 private:
  double border_view_angle() const;

  CameraModel model_ = CameraModel::kPinhole;
  int width_ = 0;
  int height_ = 0;
  std::vector<double> params_;
  double max_radius_ = 0.0;  // end of the range of validity, in the model's own radial variable
  double max_view_angle_ = 0.0;
};

}  // namespace cpplus
