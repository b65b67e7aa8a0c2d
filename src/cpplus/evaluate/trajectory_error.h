#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "cpplus/evaluate/statistics.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// How an estimated trajectory is laid over the reference before it is compared (Table I of Zhang & Scaramuzza, "A
/// Tutorial on Quantitative Trajectory Evaluation for Visual(-Inertial) Odometry", IROS 2018). An estimate that lives
/// in the map needs none; the others take out what a sensor set-up cannot observe.
enum class TrajectoryAlignment {
  kNone,
  kPositionYaw,  // 4 degrees of freedom: translation and rotation about the map's z axis
  kSe3,          // rotation and translation
  kSim3,         // rotation, translation and scale
};

const char* trajectory_alignment_name(TrajectoryAlignment alignment);

/// x' = scale * rotation * x + translation, from the estimate's frame to the reference's.
struct Similarity3 {
  double scale = 1.0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return scale * (rotation * x) + translation; }
};

/// The transform of the given kind that brings the estimate's camera centres closest to the reference's in the least
/// squares sense (Umeyama 1991). Nothing where the positions do not determine it: none at all; fewer than three or all
/// on a line for kSe3 and kSim3; all above each other for kPositionYaw.
/// Poses are map_from_camera, element i of both lists is the same instant; the lists must be equally long (else Error).
std::optional<Similarity3> align_trajectory(const std::vector<Rigid3>& estimate_map_from_camera,
                                            const std::vector<Rigid3>& reference_map_from_camera,
                                            TrajectoryAlignment alignment);

struct TrajectoryError {
  SampleStatistics translation_m;
  SampleStatistics rotation_deg;
};

/// Absolute trajectory error after the transform; its `rms` is the usual ATE. The translation error of a pose is the
/// plain distance of the two centres (as the tutorial's own software has it), which unlike the tutorial's Eq. 24 does
/// not depend on where the map has its origin.
TrajectoryError absolute_trajectory_error(const std::vector<Rigid3>& estimate_map_from_camera,
                                          const std::vector<Rigid3>& reference_map_from_camera,
                                          const Similarity3& reference_from_estimate);

using PosePairs = std::vector<std::pair<size_t, size_t>>;

/// All (i, i + step) of num_poses poses.
PosePairs pose_pairs_by_step(size_t num_poses, size_t step);

/// For each pose the first later one at least length_m away along the reference's path; none for the tail.
PosePairs pose_pairs_by_length(const std::vector<Rigid3>& reference_map_from_camera, double length_m);

/// Relative error over the pairs (i, j): the motion from i to j of the estimate against the reference's, expressed in
/// camera j of the reference. `scale` multiplies the estimate's translations (Sim(3) alignment; else 1).
TrajectoryError relative_pose_error(const std::vector<Rigid3>& estimate_map_from_camera,
                                    const std::vector<Rigid3>& reference_map_from_camera, const PosePairs& pairs,
                                    double scale = 1.0);

}  // namespace cpplus
