#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// Some points on their way into an image, one array a coordinate: loops over them become vector instructions, and the
/// processor's nearest cache holds them.
class PointBlock {
 public:
  static constexpr size_t kSize = 512;

  /// origin_in_map: of the positions.
  PointBlock(const Camera& camera, const Rigid3& camera_from_map, const Eigen::Vector3d& origin_in_map);

  size_t size() const { return size_; }
  size_t room() const { return kSize - size_; }
  bool full() const { return size_ == kSize; }
  void clear() { size_ = 0; }
  void add(const Eigen::Vector3f& position) { position_[size_++] = position; }
  /// At most as many as there is room for.
  void add(std::span<const Eigen::Vector3f> positions) {
    std::copy(positions.begin(), positions.end(), position_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += positions.size();
  }

  /// Takes all positions into the camera's frame, then into the image: pixel NaN where the camera sees no point.
  void project();

  float x(size_t i) const { return x_[i]; }
  float y(size_t i) const { return y_[i]; }
  float z(size_t i) const { return z_[i]; }
  float range(size_t i) const { return range_[i]; }  // distance from the camera, metres
  float column(size_t i) const { return column_[i]; }
  float row(size_t i) const { return row_[i]; }

 private:
  void to_camera();

  const Camera& camera_;
  std::array<float, 9> rotation_;  // camera from map, by rows
  std::array<float, 3> center_from_origin_;
  size_t size_ = 0;
  std::array<Eigen::Vector3f, kSize> position_;
  std::array<float, kSize> x_, y_, z_, range_, column_, row_;
};

}  // namespace cpplus
