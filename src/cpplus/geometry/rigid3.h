#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cpplus {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A rigid transform b_from_a:   x_in_b = rotation * x_in_a + translation.
///
/// The rotation is a unit quaternion (Eigen's memory order x y z w), the translation is in metres.
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Rigid3() = default;
  Rigid3(const Eigen::Quaterniond& q, const Eigen::Vector3d& t) : rotation(q.normalized()), translation(t) {}
  Rigid3(const Eigen::Matrix3d& r, const Eigen::Vector3d& t)
      : rotation(Eigen::Quaterniond(r).normalized()), translation(t) {}

  Eigen::Vector3d operator*(const Eigen::Vector3d& x_in_a) const { return rotation * x_in_a + translation; }
};

/// a_from_b.
Rigid3 inverse(const Rigid3& b_from_a);

/// c_from_a = c_from_b * b_from_a.
Rigid3 operator*(const Rigid3& c_from_b, const Rigid3& b_from_a);

/// Rotation matrix of the rotation vector (axis times angle, rad).
Eigen::Matrix3d so3_exp(const Eigen::Vector3d& rotation_vector);
Eigen::Vector3d so3_log(const Eigen::Quaterniond& rotation);

/// The 6-vector perturbation used everywhere (covariances, solver, errors): rotation (rad) then translation (m), on the
/// right of map_from_camera, hence in the camera frame:
///
///   R_map_camera <- R_map_camera * Exp(delta.head<3>()),   t_map_camera <- t_map_camera + R_map_camera *
///   delta.tail<3>()
///
/// Written for the stored direction: returns the camera_from_map of the perturbed camera.
Rigid3 perturb_camera(const Rigid3& camera_from_map, const Vector6d& delta);

/// The delta with perturb_camera(from, delta) == to.
Vector6d camera_difference(const Rigid3& from_camera_from_map, const Rigid3& to_camera_from_map);

/// What a perturbation moves a point in the camera's frame by, to first order: that of
/// Exp(-delta.head<3>()) (x_in_camera - delta.tail<3>()) by delta.
inline Eigen::Matrix<double, 3, 6> d_camera_point_d_delta(const Eigen::Vector3d& x_in_camera) {
  Eigen::Matrix<double, 3, 6> derivative;
  derivative << 0, -x_in_camera.z(), x_in_camera.y(), -1, 0, 0,  //
      x_in_camera.z(), 0, -x_in_camera.x(), 0, -1, 0,            //
      -x_in_camera.y(), x_in_camera.x(), 0, 0, 0, -1;
  return derivative;
}

/// Angle of the relative rotation, rad, in [0, pi].
double rotation_angle_between(const Rigid3& x, const Rigid3& y);

/// Position of the origin of frame a's observer: for camera_from_map, the camera centre in the map.
Eigen::Vector3d camera_center(const Rigid3& camera_from_map);

}  // namespace cpplus
