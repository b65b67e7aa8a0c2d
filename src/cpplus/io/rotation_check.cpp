#include "cpplus/io/rotation_check.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <cmath>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

constexpr double kMaxError = 0.01;

}  // namespace

Eigen::Quaterniond checked_rotation(const std::string& where, const Eigen::Quaterniond& quaternion) {
  if (!(std::abs(quaternion.norm() - 1.0) <= kMaxError)) {
    throw Error(fmt::format("{}: the quaternion has length {:.6g}, not 1", where, quaternion.norm()));
  }
  return quaternion.normalized();
}

Eigen::Quaterniond checked_rotation(const std::string& where, const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d stretch = svd.singularValues();
  if (!((stretch.array() - 1.0).abs().maxCoeff() <= kMaxError)) {
    throw Error(
        fmt::format("{}: not a rotation matrix: it stretches by {:.4g} to {:.4g}", where, stretch.z(), stretch.x()));
  }
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  if (rotation.determinant() < 0.0) {
    throw Error(fmt::format("{}: not a rotation matrix but a reflection (determinant -1)", where));
  }
  return Eigen::Quaterniond(rotation).normalized();
}

}  // namespace cpplus
