#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/colorize/colorize.h"
#include "cpplus/io/scratch_file.h"

namespace cpplus {

/// The colours of the points in some roots of a map, in a temporary file: 12 bytes a point. Reading is safe from
/// several threads.
class MapColors {
 public:
  /// `roots` ascending; `target`: file that the temporary is for (io/scratch_file.h). Keeps a reference to the map.
  MapColors(const VoxelMap& map, std::vector<uint32_t> roots, const std::string& target);

  const VoxelMap& map() const { return map_; }
  const std::vector<uint32_t>& roots() const { return roots_; }

  /// The points of one of the roots, in map order. Throws Error where they cannot be written.
  void write(uint32_t root, std::span<const ColoredPoint> points);
  /// Nothing for another root.
  std::vector<ColoredPoint> read(uint32_t root) const;

 private:
  const VoxelMap& map_;
  std::vector<uint32_t> roots_;
  std::vector<uint64_t> points_before_;  // those of the roots before each one
  ScratchFile file_;
};

}  // namespace cpplus
