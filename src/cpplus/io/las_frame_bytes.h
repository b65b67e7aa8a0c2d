#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cpplus/cloud/point_cloud.h"

namespace cpplus {

/// A LAS frame as it stands in a section of a voxel map file: scale and offset (3 float64 each), encoding (uint16),
/// number of records (uint32), then each record: user id and description (uint32 length and text), id (uint16), content
/// (uint32 length and bytes).
std::vector<uint8_t> las_frame_bytes(const LasFrame& frame);

/// Nothing where the bytes are no such frame.
std::optional<LasFrame> parse_las_frame(std::span<const uint8_t> bytes);

}  // namespace cpplus
