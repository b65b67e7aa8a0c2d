#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/scan_set.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

struct DynamicsOptions {
  /// Rays are followed at most so far, metres. (0, inf)
  double max_range_m = 50.0;
  /// A ray sees through a leaf when it passes the mean of its points within this distance, metres. (0, inf)
  double ray_radius_m = 0.055;
  /// Rays end this far before the point that they hit, metres. [0, inf)
  double min_gap_m = 0.25;
  /// And this far, metres, above the plane that the point lies on: rays that graze it end earlier. [0, inf)
  double surface_gap_m = 0.1;
  /// Or this share of the range, where the point lies on no plane that is known. [0, 1)
  double range_gap = 0.05;
  /// Rays that meet a plane at less than this angle, degrees, do not see through it. [0, 90)
  double min_grazing_deg = 8.0;
  /// A scan that hits a plane beside a leaf does not see through the leaf within this distance of the plane, metres;
  /// beside a hit that is on no plane it never does. [0, inf)
  double plane_distance_m = 0.05;
  /// A leaf is dynamic when at least one scan sees through it, and at least this share of the scans that hit it. [0,
  /// inf)
  double min_share = 0.25;
  /// And at least this share of the scans that hit something off planes around it: what stands there, but has gaps, is
  /// seen through by few of them. [0, inf)
  double region_share = 0.3;
  /// A leaf off planes that one scan alone hits is dynamic, too, when rays of two scans at least pass it this near,
  /// metres. (0, inf)
  double near_radius_m = 0.12;
  /// Such a ray must go on so far that it would have met a surface in the leaf at this angle before, degrees: it is
  /// none that ends on the ground behind. [0, 90)
  double near_grazing_deg = 4.0;
  /// And of this share of the scans that hit something off planes around it. (0, inf)
  double near_share = 2.0;
  /// A dynamic leaf that fewer scans see through than this share of those that hit it is not sure. (0, inf)
  double sure_share = 1.5;
  /// One that is not sure becomes static where less than this share of the leaves around it is dynamic. [0, 1]
  double keep_share = 0.5;
  /// A static leaf becomes dynamic where this share of what its scans hit around it is. (0, 1]
  double fill_share = 0.25;
  /// Points that stand out so far of the ground beside something dynamic belong to it, metres. (0, inf)
  double min_height_m = 0.05;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("max_range_m", max_range_m, "Rays are followed at most so far, metres.");
    visitor("ray_radius_m", ray_radius_m,
            "A ray sees through a leaf when it passes the mean of its points within this distance, metres.");
    visitor("min_gap_m", min_gap_m, "Rays end this far before the point that they hit, metres.");
    visitor("surface_gap_m", surface_gap_m,
            "And this far, metres, above the plane that the point lies on: rays that graze it end earlier.");
    visitor("range_gap", range_gap,
            "Or this share of the range, where the point lies on no plane that is known. [0, 1)");
    visitor("min_grazing_deg", min_grazing_deg,
            "Rays that meet a plane at less than this angle do not see through it, degrees. [0, 90)");
    visitor("plane_distance_m", plane_distance_m,
            "A scan that hits a plane beside a leaf does not see through the leaf within this distance of it, metres.");
    visitor("min_share", min_share,
            "A leaf is dynamic when a scan sees through it, and at least this share of the scans that hit it.");
    visitor("region_share", region_share,
            "And at least this share of the scans that hit something off planes around it.");
    visitor("near_radius_m", near_radius_m,
            "What one scan alone hits off planes is dynamic, too, when two scans' rays pass it this near, metres.");
    visitor("near_grazing_deg", near_grazing_deg,
            "Such a ray goes on so far that it would have met a surface in the leaf at this angle before, degrees.");
    visitor("near_share", near_share, "And of this share of the scans that hit something off planes around it.");
    visitor("sure_share", sure_share,
            "A dynamic leaf that fewer scans see through than this share of those that hit it is not sure.");
    visitor(
        "keep_share", keep_share,
        "One that is not sure becomes static where less than this share of the leaves around it is dynamic. [0, 1]");
    visitor("fill_share", fill_share,
            "A static leaf becomes dynamic where this share of what its scans hit around it is. (0, 1]");
    visitor("min_height_m", min_height_m,
            "Points that stand out so far of the ground beside something dynamic belong to it, metres.");
  }
};

struct DynamicsResult {
  std::vector<uint8_t> labels;  // by point of the scans: 0 static, 1 dynamic; non-finite points are static
  size_t num_dynamic = 0;
  size_t num_dynamic_leaves = 0;
};

/// Finds the points of things that moved while the scans were taken: what one scan hits and another sees through
/// (Schauer & Nuechter, PeopleRemover, 2018; section IV-B of the paper that this program follows). `map` is the voxel
/// map of scans.points. Time is linear in the points. See docs/dynamics.md.
DynamicsResult find_dynamics(const VoxelMap& map, const ScanSet& scans, const DynamicsOptions& options);

}  // namespace cpplus
