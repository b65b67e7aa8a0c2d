#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "cpplus/adjust/correction_solver.h"
#include "cpplus/adjust/scan_patches.h"
#include "cpplus/adjust/scan_thickness.h"
#include "cpplus/cloud/scan_set.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct AdjustOptions {
  PatchOptions patches;
  SolveOptions solve;
  /// At most so many points of a scan are used, half of them to adjust and half to judge. [100, inf)
  int points_per_scan = 40000;
  /// Patches are found anew at most so often. [1, inf)
  int max_iterations = 8;
  /// The adjusted poses are taken when they lower the mean squared thickness of held-out points by at least this share.
  /// [0, 1)
  double min_gain = 0.01;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor.group("patches", patches);
    visitor.group("solve", solve);
    visitor("points_per_scan", points_per_scan,
            "At most so many points of a scan are used, half of them to adjust and half to judge. [100, inf)");
    visitor("max_iterations", max_iterations, "Patches are found anew at most so often. [1, inf)");
    visitor("min_gain", min_gain,
            "Adjusted poses must lower the mean squared thickness of held-out points by this share. [0, 1)");
  }
};

enum class AdjustStatus {
  kAdjusted,
  kKeptTooFewScans,    // fewer than three
  kKeptTooFewPatches,  // planes that several scans see
  kKeptNotThinner,     // held-out points get no thinner
};

/// "adjusted", "kept_too_few_scans", "kept_too_few_patches", "kept_not_thinner".
std::string status_name(AdjustStatus status);

/// A direction that the scans do not hold: its standard deviation is more than half of what the priors alone give.
struct WeakDirection {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // unit, map frame
  double sigma_m = 0.0;
};

struct ScanAdjustment {
  Vector6d correction = Vector6d::Zero();  // that was found: rotation (rad), displacement (m), map frame
  Vector6d sigma = Vector6d::Zero();       // of it, the common motion of all scans taken out
  size_t num_patches = 0;
  std::vector<WeakDirection> weak_directions;
};

struct AdjustResult {
  AdjustStatus status = AdjustStatus::kKeptTooFewScans;
  std::vector<Rigid3> map_from_lidar;  // adjusted, or as they came in
  std::vector<ScanAdjustment> scans;   // what was found, taken or not
  ThicknessChange thickness;           // of held-out points, by the poses that were found
  size_t num_patches = 0;
  int iterations = 0;
  bool has_converged = false;
};

/// Adjusts the poses of scans so that the planes that several of them see get thin (Liu & Zhang, BALM, 2021: least
/// smallest eigenvalues of the points of patches, over adaptive voxels). The scans come moved to the map frame by
/// map_from_lidar. Judged by points that had no part in it: where those get no thinner, the poses stay as they are.
/// See docs/adjust.md.
AdjustResult adjust_scans(const ScanSet& scans, const std::vector<Rigid3>& map_from_lidar,
                          const AdjustOptions& options);

/// Moves the points of each scan from the one pose to the other.
void move_scans(const std::vector<Rigid3>& from_map_from_lidar, const std::vector<Rigid3>& to_map_from_lidar,
                ScanSet* scans);

}  // namespace cpplus
