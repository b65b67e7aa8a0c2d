#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace cpplus {

// The file format of a voxel map, .vox (docs/index.md): header, table of sections, then the sections, each of them one
// array of cloud/voxel_map_arrays.h or one attribute in map order, at a multiple of 64 bytes. Little-endian.

inline constexpr std::array<char, 8> kVoxelMapMagic = {'C', 'P', '+', 'V', 'O', 'X', 'E', 'L'};
/// Goes up with every change that an older reader would not understand.
inline constexpr uint32_t kVoxelMapVersion = 1;
inline constexpr uint32_t kByteOrderMark = 0x01020304;
inline constexpr uint64_t kSectionAlignment = 64;

struct VoxelMapHeader {
  std::array<char, 8> magic = kVoxelMapMagic;
  uint32_t byte_order = kByteOrderMark;
  uint32_t version = kVoxelMapVersion;
  uint64_t file_size = 0;  // bytes
  uint32_t num_sections = 0;
  uint32_t checksum = 0;  // CRC-32 of header and table of sections, with 0 in this place
  double root_size_m = 0.0;
  double leaf_size_m = 0.0;
  std::array<double, 3> origin{};  // of the positions, map frame, metres
  uint64_t num_points = 0;
  uint64_t num_dropped_non_finite = 0;
};
static_assert(sizeof(VoxelMapHeader) == 88 && std::is_trivially_copyable_v<VoxelMapHeader>);

/// What a section holds. The numbers are those in the files: new ones go to the end.
enum class VoxelMapSection : uint32_t {
  kPositions = 1,
  kInputIndices = 2,
  kRootKeys = 3,
  kRootTable = 4,
  kFirst = 5,  // one of these five a layer, see VoxelMapLayer
  kChildMask = 6,
  kMomentsMask = 7,
  kMomentsRank = 8,
  kMoments = 9,
  kIntensities = 10,
  kColors = 11,
  kStamps = 12,
  kNumViews = 13,
  kBestImages = 14,
  kColorSpreads = 15,
  kLasFrame = 16
};

struct VoxelMapSectionEntry {
  VoxelMapSection kind = VoxelMapSection::kPositions;
  uint32_t layer = 0;     // of the five that each layer has, else 0
  uint64_t offset = 0;    // in the file, bytes
  uint64_t size = 0;      // bytes
  uint32_t checksum = 0;  // CRC-32 of the content
  uint32_t reserved = 0;
};
static_assert(sizeof(VoxelMapSectionEntry) == 32 && std::is_trivially_copyable_v<VoxelMapSectionEntry>);
static_assert(std::endian::native == std::endian::little, "sections are mapped as they are");

inline uint64_t aligned_offset(uint64_t offset) {
  return (offset + kSectionAlignment - 1) / kSectionAlignment * kSectionAlignment;
}

}  // namespace cpplus
