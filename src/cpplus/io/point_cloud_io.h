#pragma once

#include <string>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/io/cloud_builder.h"
#include "cpplus/io/cloud_stream.h"

namespace cpplus {

/// Reads a point cloud in the format of its extension (.pcd, .ply, .las; any case), with intensity, colour, stamps and
/// view counts where the file has them. Streams: the peak is the cloud itself plus about a megabyte.
///
/// Non-finite points are dropped; `counts`, where given, says how many. How the origin is chosen: see CloudBuilder.
/// Throws Error with one line that names the file for anything that is not a whole, plausible file with at least one
/// finite point.
PointCloud read_point_cloud(const std::string& path, ReadCounts* counts = nullptr);

/// Writes the cloud in the format of the extension, through a temporary file. Throws Error for an unknown extension, a
/// cloud whose attribute arrays differ in length, and where the file cannot be written.
void write_point_cloud(const std::string& path, const PointCloud& cloud);
/// The same of a cloud that comes in blocks; LAS passes over it twice.
void write_point_cloud(const std::string& path, const CloudStream& cloud);

/// The lower-case extension with its dot where read_point_cloud knows it, else "".
std::string point_cloud_extension(const std::string& path);

}  // namespace cpplus
