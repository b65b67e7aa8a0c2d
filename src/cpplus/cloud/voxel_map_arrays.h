#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace cpplus {

/// Mean and covariance of a node's points, rounded to float32 after summing in double. Relative to the centre of the
/// node's root, so rounding is 6e-8 of half the root size whatever the map's coordinates.
struct VoxelMoments {
  Eigen::Vector3f mean;               // metres
  std::array<float, 6> covariance{};  // xx xy xz yy yz zz, square metres
};

/// Nodes of one layer, in the order of their points.
struct VoxelMapLayer {
  std::span<const uint32_t> first;         // nodes + 1: first child in the layer below, or first point of a leaf
  std::span<const uint8_t> child_mask;     // inner layers: bit o set = the child in octant o exists
  std::span<const uint64_t> moments_mask;  // inner layers: one bit a node: its moments are stored
  std::span<const uint32_t> moments_rank;  // inner layers: moments stored before each word of moments_mask
  std::span<const VoxelMoments> moments;
};

/// The arrays of a voxel map: plain sorted arrays without pointers, so that they can lie in memory or in a mapped
/// file alike. `owner` keeps them alive.
struct VoxelMapArrays {
  std::span<const Eigen::Vector3f> positions;  // map order, relative to the map's origin, metres
  std::span<const uint32_t> input_indices;     // map order
  std::span<const Eigen::Vector3i> root_keys;  // ascending by x, y, z
  std::span<const uint32_t> root_table;        // open addressing, see probe_key_table()
  std::vector<VoxelMapLayer> layers;           // roots first
  size_t num_dropped = 0;                      // non-finite points of the input
  std::shared_ptr<const void> owner;
};

}  // namespace cpplus
