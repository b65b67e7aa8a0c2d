#include "cpplus/geometry/rigid3.h"

#include <cmath>

namespace cpplus {
namespace {

/// Of the rotation vector (axis times angle, rad).
Eigen::Quaterniond quaternion_exp(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  const double sine_per_angle = angle < 1e-12 ? 0.5 : std::sin(0.5 * angle) / angle;
  Eigen::Quaterniond q;
  q.w() = std::cos(0.5 * angle);
  q.vec() = sine_per_angle * rotation_vector;
  return q;
}

}  // namespace

Rigid3 inverse(const Rigid3& b_from_a) {
  const Eigen::Quaterniond a_from_b = b_from_a.rotation.conjugate();
  return {a_from_b, -(a_from_b * b_from_a.translation)};
}

Rigid3 operator*(const Rigid3& c_from_b, const Rigid3& b_from_a) {
  return {c_from_b.rotation * b_from_a.rotation, c_from_b.rotation * b_from_a.translation + c_from_b.translation};
}

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& rotation_vector) {
  return quaternion_exp(rotation_vector).toRotationMatrix();
}

Eigen::Vector3d so3_log(const Eigen::Quaterniond& rotation) {
  // atan2 of the quaternion's parts keeps full precision for small angles, where acos(w) does not.
  const double sign = rotation.w() < 0 ? -1.0 : 1.0;
  const Eigen::Vector3d vec = sign * rotation.vec();
  const double sin_half = vec.norm();
  if (sin_half < 1e-12) return 2.0 * vec;
  return vec * (2.0 * std::atan2(sin_half, sign * rotation.w()) / sin_half);
}

Rigid3 perturb_camera(const Rigid3& camera_from_map, const Vector6d& delta) {
  const Eigen::Quaterniond turned_back = quaternion_exp(-delta.head<3>());
  return {turned_back * camera_from_map.rotation, turned_back * (camera_from_map.translation - delta.tail<3>())};
}

Vector6d camera_difference(const Rigid3& from_camera_from_map, const Rigid3& to_camera_from_map) {
  const Rigid3 from_from_to = from_camera_from_map * inverse(to_camera_from_map);
  Vector6d delta;
  delta << so3_log(from_from_to.rotation), from_from_to.translation;
  return delta;
}

double rotation_angle_between(const Rigid3& x, const Rigid3& y) {
  return so3_log(x.rotation.conjugate() * y.rotation).norm();
}

Eigen::Vector3d camera_center(const Rigid3& camera_from_map) {
  return -(camera_from_map.rotation.conjugate() * camera_from_map.translation);
}

}  // namespace cpplus
