#pragma once

#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "cpplus/cloud/point_cloud.h"

namespace cpplus::bench {

/// What the benchmarks voxelise: storeys of rooms, 6 x 5 x 3 m with four pieces of furniture each, sampled evenly by
/// area with 1.5 cm of normal noise. As many rooms as the points fill at the density.
struct World {
  size_t num_points = 0;
  /// Dense: 2,600 points a square metre, 5 to 6 in a leaf of 62.5 mm. Sparse: 400, 1.7 in a leaf.
  bool sparse = false;
  /// Room after room with the points of a room in random order, as scans add up; or all points in random order.
  bool shuffled = false;

  bool operator==(const World&) const = default;
  std::string name() const;
};

/// The leaf size of every benchmark, metres.
inline constexpr double leaf_size_m = 0.0625;

/// Kept until another world is asked for.
const PointCloud& cloud_of(const World& world);
/// Centre of the room that holds point i of the cloud, for the peers that trace rays.
Eigen::Vector3f room_center(const Eigen::Vector3f& position);

/// Gives freed memory back to the system, outside the time measured. Each build then pays for its own memory, as it
/// does in a program that builds one map; otherwise those that free small blocks would find theirs warm.
void return_memory(benchmark::State* state);

void register_pcl(const World& world);
void register_open3d(const World& world);
void register_octomap(const World& world);

}  // namespace cpplus::bench
