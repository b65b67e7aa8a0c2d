#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/options.h"

namespace cpplus {

struct PlaneSegmentationOptions {
  /// A voxel is planar when its smallest eigenvalue is at most this share of the middle one. (0, 1)
  double max_eigenvalue_ratio = 0.06;
  /// RMS distance above which points do not make a plane, metres. (0, inf)
  double max_thickness_m = 0.04;
  /// Fewest points of a planar voxel that starts a plane. [4, inf)
  int min_seed_points = 12;
  /// Fewest points of a plane instance. [4, inf)
  int min_plane_points = 40;
  /// A point joins a plane within this many sigmas of it. (0, inf)
  double max_distance_sigmas = 3.0;
  /// Largest angle between a plane and the surface around a leaf that joins it, degrees. (0, 90)
  double max_angle_deg = 30.0;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("max_eigenvalue_ratio", max_eigenvalue_ratio,
            "A voxel is planar below this ratio of smallest to middle eigenvalue.");
    visitor("max_thickness_m", max_thickness_m, "RMS distance above which points do not make a plane, metres.");
    visitor("min_seed_points", min_seed_points, "Fewest points of a planar voxel that starts a plane.");
    visitor("min_plane_points", min_plane_points, "Fewest points of a plane instance.");
    visitor("max_distance_sigmas", max_distance_sigmas, "A point joins a plane within this many sigmas of it.");
    visitor("max_angle_deg", max_angle_deg, "Largest angle between a plane and the surface of a leaf that joins it.");
  }
};

/// Finds the plane instances of the map: planar voxels by their eigenvalue ratio, coarse to fine (Cui & Schwertfeger
/// 2022, section IV-D, after Liu & Zhang 2021), each grown over neighbouring leaves point by point. A point belongs to
/// one plane at most, so both faces of a thin wall become planes of their own although they share voxels.
/// Linear in the number of points. The result does not depend on the number of threads. `noise_m`: the range noise of
/// the map, where it is known from more than this map; otherwise that of all its roots.
PlaneSegmentation segment_planes(const VoxelMap& map, const PlaneSegmentationOptions& options,
                                 std::optional<double> noise_m = std::nullopt);

/// The range noise of a map, standard deviation in metres, from the planar voxels in some of its roots.
double range_noise_m(const VoxelMap& map, std::span<const uint32_t> roots, const PlaneSegmentationOptions& options);

}  // namespace cpplus
