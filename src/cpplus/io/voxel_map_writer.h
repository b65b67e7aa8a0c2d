#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cpplus/cloud/point_map.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/point_attributes.h"
#include "cpplus/io/scratch_file.h"
#include "cpplus/io/voxel_map_format.h"

namespace cpplus {

/// What is known of a map before its points are sorted.
struct VoxelMapOutline {
  VoxelMapOptions options;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // of the positions, map frame, metres
  size_t num_points = 0;
  size_t num_dropped_non_finite = 0;
  PointAttributes attributes;
  std::optional<LasFrame> las_frame;
};

/// Writes a voxel map file piece by piece: pieces are maps of disjoint sets of roots, in the order of the roots. The
/// file is the same whatever the pieces, and appears with commit(), whole or not at all.
class VoxelMapWriter {
 public:
  /// Throws Error naming the path where it cannot be written.
  VoxelMapWriter(const std::string& path, const VoxelMapOutline& outline);
  ~VoxelMapWriter();
  VoxelMapWriter(const VoxelMapWriter&) = delete;
  VoxelMapWriter& operator=(const VoxelMapWriter&) = delete;

  /// Where a piece goes: in each section behind those before.
  struct Place {
    size_t piece = 0;
    std::vector<uint64_t> begins;  // by section, bytes
  };

  /// The place of the next piece. One call at a time, in the order of the pieces.
  Place reserve(const PointMap& piece);

  /// Writes the piece; several threads may write one each. `input_indices[i]`: place in the whole input of point i of
  /// the piece's input.
  void write(const PointMap& piece, std::span<const uint32_t> input_indices, const Place& place);

  /// After all pieces. Writes what is known at the end only, and renames.
  void commit();

 private:
  struct Section;
  struct Layer;
  /// What a piece has of a section.
  struct Part {
    uint64_t size = 0;  // bytes
    uint32_t checksum = 0;
  };

  Section* add_section(VoxelMapSection kind, uint32_t layer, std::optional<uint64_t> size);
  template <typename T>
  void append(Section* section, std::span<const T> values);
  void append_moments_mask(size_t l, const VoxelMapLayer& nodes);
  uint32_t children_before(size_t l, const Place& place) const;
  void join_checksums();
  void finish_layers();
  void place_grown_sections();
  void write_at(const Section& section, uint64_t offset, const void* data, size_t size);

  AtomicFile file_;
  ScratchFile out_;  // its temporary
  VoxelMapOutline outline_;
  std::vector<std::unique_ptr<Section>> sections_;  // in the order of the file
  Section* positions_ = nullptr;
  std::vector<Layer> layers_;
  std::vector<Eigen::Vector3i> root_keys_;
  uint64_t num_points_ = 0;
  uint64_t end_ = 0;  // of the sections with a place
  size_t num_pieces_ = 0;
  std::mutex mutex_;
  std::vector<std::vector<Part>> parts_;  // by piece, then by section
};

}  // namespace cpplus
