#pragma once

#include <memory>
#include <string>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/io/cloud_source.h"
#include "cpplus/io/cloud_stream.h"

namespace cpplus {

/// Opens LAS 1.2 to 1.4 with point formats 0-3 and 6-8: positions, intensity (0..65535), GPS time as it stands, colour
/// (16-bit, or 8-bit where no channel of the file exceeds 255), and the extra bytes "num_views", "best_image" and
/// "color_spread". The file's grid and
/// coordinate system are kept in PointCloud::las_frame.
std::unique_ptr<CloudSource> open_las(const std::string& path);

/// Writes LAS 1.4 with point format 0 (bare), 1 (stamps), 2 (colour) or 3 (both); 6 or 7 (colour), which always have a
/// stamp (0 without stamps), where the coordinate system is WKT or the points are too many for the others. View counts,
/// best images and spreads of colour are extra bytes.
///
/// Coordinates go onto the grid of the cloud's las_frame; a cloud read from LAS gets back its very integers as long as
/// it reaches less than 2^23 steps from its origin (8 km at a scale of 1 mm; float32 offsets carry no more). Without a
/// frame, or where the cloud does not fit into its 32-bit integers, the offset is the cloud's origin; without a frame
/// the scale is 0.1 mm. Intensities are rounded and clamped to 16 bits; if all lie in [0, 1] and some are fractions,
/// they are stretched by 65535 first. Throws Error for a cloud that is too large for the grid.
void write_las(const std::string& path, const CloudStream& cloud);

}  // namespace cpplus
