#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "cpplus/cloud/point_map.h"
#include "cpplus/cloud/voxel_map_arrays.h"

namespace cpplus {

/// What a layer of a voxel map in memory lies in.
struct OwnedLayer {
  std::vector<uint32_t> first;
  std::vector<uint8_t> child_mask;
  std::vector<uint64_t> moments_mask;
  std::vector<uint32_t> moments_rank;
  std::vector<VoxelMoments> moments;

  VoxelMapLayer view() const { return {first, child_mask, moments_mask, moments_rank, moments}; }
};

/// What the attributes of a map in memory lie in, each in map order or empty.
struct OwnedAttributes {
  std::vector<float> intensities;
  std::vector<Rgb> colors;
  std::vector<double> stamps_s;
  std::vector<uint16_t> num_views;
  std::vector<uint32_t> best_images;
  std::vector<uint8_t> color_spreads;

  /// Makes these the attributes of a map; `owner` keeps them alive.
  void view(std::shared_ptr<const void> owner, PointMap* points) const {
    points->intensities = intensities;
    points->colors = colors;
    points->stamps_s = stamps_s;
    points->num_views = num_views;
    points->best_images = best_images;
    points->color_spreads = color_spreads;
    points->owner = std::move(owner);
  }
};

}  // namespace cpplus
