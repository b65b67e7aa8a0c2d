#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// The points of one scan on a patch: all that the adjustment needs of them, however many they are.
struct ScanCluster {
  uint32_t scan = 0;
  double count = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();        // map frame, metres
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // divided by count, square metres
};

/// A piece of a plane that several scans see from the same side; clusters ascend by scan.
struct ScanPatch {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, map frame
  std::vector<ScanCluster> clusters;
};

struct PatchOptions {
  /// Edge of the largest and the smallest voxels that hold a patch, metres; their ratio must be a power of two up to
  /// 256. (0, inf)
  double largest_m = 2.0;
  double smallest_m = 0.25;
  /// A patch is seen by at least so many scans, each with at least so many points. [2, inf), [1, inf)
  int min_scans = 3;
  int min_points = 5;
  /// RMS distance of all points from the plane at most, metres: room for the error of the poses. (0, inf)
  double max_thickness_m = 0.1;
  /// And at most this share of the patch's second largest RMS extent. (0, 1)
  double max_flatness = 0.2;
  /// A voxel is divided when its parts are thinner than it: sum of their squared distances below this share. (0, 1]
  double split_ratio = 0.75;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("largest_m", largest_m, "Edge of the largest voxels that hold a patch, metres.");
    visitor("smallest_m", smallest_m, "Edge of the smallest; largest / smallest must be a power of two up to 256.");
    visitor("min_scans", min_scans, "A patch is seen by at least so many scans. [2, inf)");
    visitor("min_points", min_points, "A scan sees a patch with at least so many points. [1, inf)");
    visitor("max_thickness_m", max_thickness_m, "RMS distance of a patch's points from its plane at most, metres.");
    visitor("max_flatness", max_flatness, "And at most this share of its second largest RMS extent. (0, 1)");
    visitor("split_ratio", split_ratio,
            "A voxel is divided when its parts' squared distances sum up to less than this share of its own. (0, 1]");
  }
};

/// Smallest and second smallest eigenvalue of a scatter, and the plane through its mean.
struct PatchPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, map frame
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();     // a point of the plane, map frame
  double smallest = 0.0;                              // mean squared distance from the plane, square metres
  double second = 0.0;
};

/// The plane with the least weighted mean squared distance of the clusters' points; one weight a cluster.
PatchPlane fit_patch_plane(const std::vector<ScanCluster>& clusters, const std::vector<double>& weights);

/// The cluster after its scan was moved.
ScanCluster moved(const ScanCluster& cluster, const Rigid3& new_map_from_map);

/// Finds the patches of the scans' points: voxels from the largest down to the smallest, each as soon as it is planar.
/// What scans see from opposite sides (a thin wall) makes two patches. scan_of_point: by point; sensors: by scan, map
/// frame, metres. The order of the patches depends on the points only. Linear in the points.
std::vector<ScanPatch> find_scan_patches(const PointCloud& points, const std::vector<uint32_t>& scan_of_point,
                                         const std::vector<Eigen::Vector3d>& sensors, const PatchOptions& options);

/// RMS distance of a scan's points from the planes: the median over the clusters of at least ten points, metres; 0
/// where there are none. The poses have no part in it.
double range_noise(const std::vector<ScanPatch>& patches);

}  // namespace cpplus
