#pragma once

#include <string>

#include "cpplus/geometry/trajectory.h"

namespace cpplus {

/// Reads a TUM trajectory: lines `stamp tx ty tz qx qy qz qw` of map_from_sensor, seconds and metres, blanks between,
/// '#' starts a comment. Throws Error naming file, line and value: commas, wrong number of values, a quaternion whose
/// length is more than 1 % off, stamps that do not ascend, no pose at all.
Trajectory read_tum(const std::string& path);

/// Writes with as many digits as bring back the same doubles.
void write_tum(const std::string& path, const Trajectory& trajectory);

/// Writes KITTI poses: for each pose the upper three rows of the matrix map_from_sensor, row by row, in one line of 12
/// numbers. Stamps are not part of the format; write_times() writes them beside it.
void write_kitti(const std::string& path, const Trajectory& trajectory);

/// One stamp a line, seconds.
void write_times(const std::string& path, const Trajectory& trajectory);

}  // namespace cpplus
