#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>

namespace cpplus {

/// The rotation that a file gives; `where` begins the message of the Error for what is none.
///
/// A quaternion up to 1 % off unit length is normalised.
Eigen::Quaterniond checked_rotation(const std::string& where, const Eigen::Quaterniond& quaternion);

/// A matrix up to 1 % off orthonormal becomes the nearest rotation; a reflection is an Error.
Eigen::Quaterniond checked_rotation(const std::string& where, const Eigen::Matrix3d& matrix);

}  // namespace cpplus
