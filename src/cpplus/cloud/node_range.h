#pragma once

#include <cstdint>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// [begin, end) of nodes of one layer.
struct NodeRange {
  uint32_t begin = 0;
  uint32_t end = 0;

  uint32_t size() const { return end - begin; }
  bool operator==(const NodeRange&) const = default;
};

/// The nodes of a layer in a node of that layer or of one above.
inline NodeRange descendants_of(const VoxelMap& map, int layer, uint32_t node, int descendants_layer) {
  NodeRange range{node, node + 1};
  for (; layer < descendants_layer; ++layer) {
    range = {map.children_begin(layer, range.begin), map.children_begin(layer, range.end)};
  }
  return range;
}

/// The leaves in a node.
inline NodeRange leaves_of(const VoxelMap& map, int layer, uint32_t node) {
  return descendants_of(map, layer, node, map.leaf_layer());
}

}  // namespace cpplus
