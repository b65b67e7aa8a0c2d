#pragma once

#include <string>
#include <vector>

#include "cpplus/geometry/trajectory.h"

namespace cpplus {

/// Reads poses map_from_sensor in the order of the file, whose first line tells which of these it is:
///
/// - TUM: `stamp tx ty tz qx qy qz qw`, blanks between;
/// - KITTI: the 12 numbers of the upper three rows of the matrix, row by row. `times` is a file with one stamp a line;
/// - csv: a header line that names the columns. Known are a stamp (timestamp, time, stamp, t, sec; [ns] in the name
/// gives
///   its unit, else image_stamps.h), the position (x, tx, p_x, position.x, p_RS_R_x ..., and the same with y and z) and
///   the quaternion (qw, q_w, q_RS_w, orientation.w ...). The order of the columns is free, others are skipped.
///
/// Stamps need not ascend (geometry/trajectory.h, order_by_stamp). Throws Error naming file, line and value: not a
/// number, wrong number of values, a quaternion or matrix that is not a rotation, a column that is missing from the
/// header, as many stamps as poses missing, no pose at all.
std::vector<StampedPose> read_pose_file(const std::string& path, const std::string& times);

/// Reads one stamp a line, seconds.
std::vector<double> read_times(const std::string& path);

}  // namespace cpplus
