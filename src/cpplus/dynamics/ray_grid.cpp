#include "cpplus/dynamics/ray_grid.h"

#include <bit>
#include <numeric>

namespace cpplus {

using Eigen::Vector3f;

namespace {

constexpr size_t kFaces = 6;

/// The layer above: the longest ray of 2 x 2 bins.
std::vector<float> halved(const std::vector<float>& reach, int bits) {
  const size_t size = size_t{1} << bits;
  std::vector<float> above(reach.size() / 4);
  for (size_t row = 0; row < kFaces * size / 2; ++row) {  // the rows of all faces lie one after the other
    const float* one = reach.data() + 2 * row * size;
    const float* other = one + size;
    for (size_t u = 0; u < size / 2; ++u) {
      above[row * size / 2 + u] =
          std::max(std::max(one[2 * u], one[2 * u + 1]), std::max(other[2 * u], other[2 * u + 1]));
    }
  }
  return above;
}

}  // namespace

size_t RayGrid::bin_of(const Vector3f& direction) const {
  Eigen::Index axis = 0;
  const float depth = direction.cwiseAbs().maxCoeff(&axis);
  const auto a = static_cast<size_t>(axis);
  const size_t face = 2 * a + (direction[axis] < 0.0f ? 1 : 0);
  const auto u = static_cast<size_t>(to_bin(direction[u_axis[a]] / depth));
  const auto v = static_cast<size_t>(to_bin(direction[v_axis[a]] / depth));
  return (face << (2 * bits_)) + (v << bits_) + u;
}

void RayGrid::assign(const std::vector<ScanRay>& rays) {
  const size_t bins_a_face = rays.size() / kFaces + 1;
  bits_ = std::min(max_bits, static_cast<int>(std::bit_width(bins_a_face) + 1) / 2);
  half_size_ = 0.5f * static_cast<float>(1 << bits_);
  const size_t num_bins = kFaces << (2 * bits_);
  first_.assign(num_bins + 1, 0);
  reach_.assign(1, std::vector<float>(num_bins, 0.0f));
  std::vector<uint32_t> bins(rays.size());
  for (size_t i = 0; i < rays.size(); ++i) {
    bins[i] = static_cast<uint32_t>(bin_of(rays[i].direction));
    ++first_[bins[i]];
    reach_[0][bins[i]] = std::max(reach_[0][bins[i]], rays[i].length_m);
  }
  // Ends first, then each ray takes a place off the end of its bin.
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  rays_.resize(rays.size());
  for (size_t i = 0; i < rays.size(); ++i) rays_[--first_[bins[i]]] = rays[i];
  for (int bits = bits_; bits > 0; --bits) reach_.push_back(halved(reach_.back(), bits));
}

float RayGrid::reach(const SensorCube& cube) const {
  if (surrounds_sensor(cube)) return std::numeric_limits<float>::infinity();
  float longest = 0.0f;
  for_each_window(cube, [&](const Window& window) {
    // The lowest layer of which the window has at most 3 x 3 bins.
    const int width = std::max(window.u_high - window.u_low, window.v_high - window.v_low);
    const int layer = std::max(0, static_cast<int>(std::bit_width(static_cast<uint32_t>(width))) - 1);
    const std::vector<float>& bins = reach_[static_cast<size_t>(layer)];
    const int bits = bits_ - layer;
    for (int v = window.v_low >> layer; v <= window.v_high >> layer; ++v) {
      const size_t row = (static_cast<size_t>(window.face) << (2 * bits)) + (static_cast<size_t>(v) << bits);
      for (int u = window.u_low >> layer; u <= window.u_high >> layer; ++u) {
        longest = std::max(longest, bins[row + static_cast<size_t>(u)]);
      }
    }
  });
  return longest;
}

}  // namespace cpplus
