#pragma once

#include <vector>

#include "cpplus/geometry/camera.h"
#include "cpplus/refine/edge_evidence.h"
#include "cpplus/refine/joint_solver.h"
#include "cpplus/refine/refine_pose.h"

namespace cpplus {

/// What the joint solve found for an image, and what is known of its surroundings.
struct JointCandidate {
  Rigid3 coarse_camera_from_map;
  JointPose pose;
  const EdgeEvidence* edges = nullptr;
  std::vector<Eigen::Vector3d> surface_in_map;  // points that the image sees
  /// Patches of it found in other images, or theirs in it, that fit the solution, minus those that do not.
  int surface_support = 0;
  /// Most images of its camera prove where they are (JointPose).
  bool most_are_proven = true;
};

/// Judges a pose of the joint solve: fills residuals (each sample judged by a pose that the other folds of edges and
/// the other images give), information, weak directions and the predicted shift. The pose is believed when it is
/// expected to be off by no more than max_predicted_shift_px, or than max_predicted_share of its way from the coarse
/// pose (of 0.7 times that where its own edges leave a direction to the others; only if most images of the camera prove
/// where they are), and its edges agree: if the other images do not place it already, more than by chance and better
/// than at the coarse pose (`held_out_before`); else edges and patches together more than by chance. What only the
/// second limit lets pass has a reason, too.
RefinePoseResult judge_joint_pose(const Camera& camera, const JointCandidate& candidate,
                                  const EdgeResidual& held_out_before, const RefinePoseOptions& options);

/// For an image whose own edges are not believed: takes the pose that everything else gives, if that is expected to be
/// off by no more than judge_joint_pose() allows where edges leave a direction to the others, and its patches do not
/// speak against it. False: nothing changed.
bool place_by_others(const Camera& camera, const JointCandidate& candidate, const RefinePoseOptions& options,
                     RefinePoseResult* result);

}  // namespace cpplus
