#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace cpplus {

/// A ray of a scan, which may be followed from the sensor for length_m.
struct ScanRay {
  Eigen::Vector3f direction;  // unit length, axes of the map
  float length_m = 0.0f;
};

/// A cube with the axes of the map; its centre is relative to the sensor. Metres.
struct SensorCube {
  Eigen::Vector3f center;
  float half_m = 0.0f;  // half of its edge

  /// Distance of its nearest point from the sensor, metres.
  float distance() const { return (center.cwiseAbs().array() - half_m).max(0.0f).matrix().norm(); }
};

/// Whether the line through the sensor meets the cube: the cross product with each axis separates them, or nothing
/// does.
inline bool line_meets(const Eigen::Vector3f& direction, const SensorCube& cube) {
  const Eigen::Vector3f off = cube.center.cross(direction).cwiseAbs();
  const Eigen::Vector3f width = cube.half_m * direction.cwiseAbs();
  return off.x() <= width.y() + width.z() && off.y() <= width.z() + width.x() && off.z() <= width.x() + width.y();
}

/// The rays of one scan by direction: bins on the six faces of a cube around the sensor, and above them layers of bins
/// twice as wide, down to one a face, that know the longest ray in them. It answers which rays meet something, which is
/// less work than to ask each ray what it meets: most of a map lies behind what a scan sees.
class RayGrid {
 public:
  /// About a bin a ray. Replaces what was there before.
  void assign(const std::vector<ScanRay>& rays);

  /// No ray that meets the cube is longer than this, metres. Infinite where the sensor is within a cube's width.
  float reach(const SensorCube& cube) const;

  /// Whether `test(ray)` is true for one of the rays that may meet the cube: all that do, and some around them.
  template <typename Test>
  bool any_ray(const SensorCube& cube, const Test& test) const;

 private:
  static constexpr int max_bits = 9;  // 512 x 512 bins a face
  static constexpr std::array<int, 3> u_axis = {1, 2, 0};
  static constexpr std::array<int, 3> v_axis = {2, 0, 1};

  /// Bins [u_low, u_high] x [v_low, v_high] of a face, of the lowest layer.
  struct Window {
    uint32_t face = 0;
    int u_low = 0, u_high = 0, v_low = 0, v_high = 0;
  };

  static bool surrounds_sensor(const SensorCube& cube) {
    return cube.center.cwiseAbs().maxCoeff() <= 2.0f * cube.half_m;
  }
  int to_bin(float u) const { return std::clamp(static_cast<int>((u + 1.0f) * half_size_), 0, (1 << bits_) - 1); }
  size_t bin_of(const Eigen::Vector3f& direction) const;

  /// Calls visit(window) for each face that the directions from the sensor to the cube meet; not for a cube that
  /// surrounds_sensor().
  template <typename Visit>
  void for_each_window(const SensorCube& cube, const Visit& visit) const;

  int bits_ = 0;                           // 2^bits_ bins along each side of a face
  float half_size_ = 0.5f;                 // of a side, bins
  std::vector<ScanRay> rays_;              // by bin
  std::vector<uint32_t> first_;            // bins + 1: first ray
  std::vector<std::vector<float>> reach_;  // by layer, the bins first: longest ray, 0 where there is none
};

template <typename Visit>
void RayGrid::for_each_window(const SensorCube& cube, const Visit& visit) const {
  const Eigen::Vector3f size = cube.center.cwiseAbs();
  // What lies in a face's pyramid of directions is at least so far along its axis, as that coordinate is the largest.
  const float near = size.maxCoeff() - cube.half_m;
  const float per_near = 1.0f / near;
  for (int axis = 0; axis < 3; ++axis) {
    const float far = size[axis] + cube.half_m;
    if (far < near) continue;
    const float per_far = 1.0f / far;
    const auto low_bin = [&](float center) {
      const float low = center - cube.half_m;
      return low * (low > 0.0f ? per_far : per_near);
    };
    const auto high_bin = [&](float center) {
      const float high = center + cube.half_m;
      return high * (high > 0.0f ? per_near : per_far);
    };
    const float u = cube.center[u_axis[static_cast<size_t>(axis)]];
    const float v = cube.center[v_axis[static_cast<size_t>(axis)]];
    const float u_low = low_bin(u), u_high = high_bin(u), v_low = low_bin(v), v_high = high_bin(v);
    if (u_low > 1.0f || u_high < -1.0f || v_low > 1.0f || v_high < -1.0f) continue;
    const uint32_t face = 2 * static_cast<uint32_t>(axis) + (cube.center[axis] < 0.0f ? 1 : 0);
    visit(Window{face, to_bin(u_low), to_bin(u_high), to_bin(v_low), to_bin(v_high)});
  }
}

template <typename Test>
bool RayGrid::any_ray(const SensorCube& cube, const Test& test) const {
  if (surrounds_sensor(cube)) return std::any_of(rays_.begin(), rays_.end(), test);
  bool found = false;
  for_each_window(cube, [&](const Window& window) {
    for (int v = window.v_low; v <= window.v_high && !found; ++v) {
      const size_t row = (static_cast<size_t>(window.face) << (2 * bits_)) + (static_cast<size_t>(v) << bits_);
      const auto begin = rays_.begin() + first_[row + static_cast<size_t>(window.u_low)];
      const auto end = rays_.begin() + first_[row + static_cast<size_t>(window.u_high) + 1];
      found = std::any_of(begin, end, test);
    }
  });
  return found;
}

}  // namespace cpplus
