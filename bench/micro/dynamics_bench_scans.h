#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "cpplus/cloud/scan_set.h"

namespace cpplus::bench {

/// Scans of an empty room from places along its middle, in which somebody 0.5 m wide walks ahead of the sensor; ranges
/// with 2 cm of noise. Sizes in metres.
ScanSet room_scans(const Eigen::Vector3d& room_m, size_t num_scans, size_t num_beams);

/// The task beside peers: 40 scans of 65,536 points in a hall of 40 x 30 x 8 m, voxels of 0.1 m.
ScanSet hall_scans();
inline constexpr double hall_voxel_m = 0.1;

#ifdef CPPLUS_BENCH_OCTOMAP
void register_octomap();
#endif

}  // namespace cpplus::bench
