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
  double range_gap = 0.04;
  /// Rays that meet a plane at less than this angle, degrees, do not see through it. [0, 90)
  double min_grazing_deg = 5.5;
  /// A scan that hits a plane beside a leaf does not see through the leaf within this distance of the plane, metres;
  /// beside a hit that is on no plane it never does. [0, inf)
  double plane_distance_m = 0.05;
  /// A leaf is dynamic when at least one scan sees through it, and at least this share of the scans that hit it. [0,
  /// inf)
  double min_share = 0.25;
  /// And at least this share of the scans that hit something off planes around it: what stands there, but has gaps, is
  /// seen through by few of them. [0, inf)
  double region_share = 0.3;
  /// A leaf that no scan sees through becomes dynamic where this share of the leaves around it is. (0, 1]
  double fill_share = 0.5;
  /// A dynamic leaf that fewer than sure_scans see through becomes static where less than this share around it is
  /// dynamic. [0, 1]
  double keep_share = 0.25;
  /// [1, inf)
  int sure_scans = 2;
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
    visitor("fill_share", fill_share,
            "A leaf that no scan sees through becomes dynamic where this share of the leaves around it is. (0, 1]");
    visitor(
        "keep_share", keep_share,
        "A dynamic leaf that few scans see through becomes static where less than this share around it is dynamic.");
    visitor("sure_scans", sure_scans, "So many scans that see through a dynamic leaf are not few. [1, inf)");
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
