#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// What an index was made of.
struct IndexSummary {
  size_t num_points = 0;
  size_t num_dropped_non_finite = 0;
  size_t num_roots = 0;
  size_t num_buckets = 0;
  bool was_sorted = false;  // by a run that was killed before its end
};

/// Builds the voxel map of the points of one or several files (.pcd .ply .las) on the disk, by an external sort, in
/// about `memory_bytes` of memory and at least what the points of one root take (docs/index.md). The arrays are byte
/// for byte those of the map in memory of all files' points one after the other, whatever the memory and the number of
/// threads. Positions are relative to the origin of the first file; attributes that some file does not have are left
/// out; a LAS frame is that of the first file.
///
/// The file appears whole or not at all. Points that are sorted are kept beside it until it is there (io/kept_sort.h):
/// where the process is killed or interrupted the next call with the same arguments and unchanged files goes on from
/// them. Throws Error naming the file for what cannot be read or written, and for a point beyond the grid or too many
/// points, as VoxelMap's constructor.
IndexSummary index_point_clouds(const std::vector<std::string>& paths, const VoxelMapOptions& options,
                                size_t memory_bytes, const std::string& out);

}  // namespace cpplus
