#include "cpplus/visibility/point_block.h"

#include <algorithm>
#include <cmath>

#include "cpplus/core/vector_clones.h"

namespace cpplus {

PointBlock::PointBlock(const Camera& camera, const Rigid3& camera_from_map, const Eigen::Vector3d& origin_in_map)
    : camera_(camera) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = camera_from_map.rotation.toRotationMatrix();
  std::transform(rotation.data(), rotation.data() + 9, rotation_.begin(),
                 [](double r) { return static_cast<float>(r); });
  // float32 holds 40 m to micrometres: the large offsets cancel in double first.
  const Eigen::Vector3f center = (camera_center(camera_from_map) - origin_in_map).cast<float>();
  std::copy_n(center.data(), 3, center_from_origin_.begin());
}

void PointBlock::project() {
  to_camera();
  camera_.project(size_, x_.data(), y_.data(), z_.data(), column_.data(), row_.data());
}

CPPLUS_VECTOR_CLONES void PointBlock::to_camera() {
  const auto [r0, r1, r2, r3, r4, r5, r6, r7, r8] = rotation_;
  const auto [center_x, center_y, center_z] = center_from_origin_;
  const float* positions = position_.data()->data();
  for (size_t i = 0; i < size_; ++i) {
    const float a = positions[3 * i] - center_x;
    const float b = positions[3 * i + 1] - center_y;
    const float c = positions[3 * i + 2] - center_z;
    x_[i] = r0 * a + r1 * b + r2 * c;
    y_[i] = r3 * a + r4 * b + r5 * c;
    z_[i] = r6 * a + r7 * b + r8 * c;
    range_[i] = std::sqrt(a * a + b * b + c * c);
  }
}

}  // namespace cpplus
