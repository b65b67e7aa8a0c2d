#pragma once

#include <string>

#include "cpplus/cloud/point_map.h"

namespace cpplus {

/// Whether the file name ends in .vox, whatever the case.
bool is_voxel_map_file(const std::string& path);

/// Maps a voxel map file into memory: the arrays are read from the disk where they are looked at, and leave memory
/// again when others need it. Checks the header, the table of sections, and that sizes and ends of the arrays agree;
/// the content is not read (verify_voxel_map_file). Throws Error with one line naming the file for a file of another
/// kind, version or byte order, one that is truncated, and one whose table is damaged.
PointMap map_voxel_map_file(const std::string& path);

/// Text that tells a voxel map file from others: its size and the checksum of its header and table, which holds those
/// of all sections. Throws as map_voxel_map_file().
std::string voxel_map_fingerprint(const std::string& path);

/// Reads all of the file and throws Error naming the section where its content is not what was written.
void verify_voxel_map_file(const std::string& path);

}  // namespace cpplus
