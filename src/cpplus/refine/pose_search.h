#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/core/options.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/edge_samples.h"
#include "cpplus/refine/edgel_index.h"
#include "cpplus/refine/pose_guess.h"

namespace cpplus {

struct PoseSearchOptions {
  /// Off: refinement starts from the coarse pose alone, as in the paper.
  bool enabled = true;
  /// Poses tried a round. [2, inf)
  int poses_per_round = 500;
  /// Rounds of the search; each looks around the best of the one before, more closely. [1, inf)
  int rounds = 6;
  /// Width of the score's kernel in the first and in the last round, pixels. (0, inf)
  double first_kernel_px = 8.0;
  double last_kernel_px = 2.5;
  /// Most edge samples that the score looks at. [1, inf)
  int max_samples = 500;
  uint64_t seed = 1;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("enabled", enabled, "Search around the coarse pose before refining it.");
    visitor("poses_per_round", poses_per_round, "Poses tried a round.");
    visitor("rounds", rounds, "Rounds of the search, each closer around the best of the one before.");
    visitor("first_kernel_px", first_kernel_px, "Width of the score's kernel in the first round, pixels.");
    visitor("last_kernel_px", last_kernel_px, "Width of the score's kernel in the last round, pixels.");
    visitor("max_samples", max_samples, "Most edge samples that the score looks at.");
  }
};

/// How far a coarse pose may be off: standard deviation of each component, in the camera frame.
struct PosePrior {
  double rotation_sigma_deg = 1.0;
  double translation_sigma_m = 0.10;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("rotation_sigma_deg", rotation_sigma_deg,
            "Standard deviation of a coarse pose's rotation about each axis, degrees.");
    visitor("translation_sigma_m", translation_sigma_m,
            "Standard deviation of a coarse pose's position along each axis, metres.");
  }
  /// Per component of the perturbation: rad, rad, rad, m, m, m.
  Vector6d sigmas() const;
};

struct PoseSearchResult {
  Rigid3 camera_from_map;
  double start_score = 0.0;  // log likelihood ratio to edges put at random
  double best_score = 0.0;
};

/// Looks for the pose whose edge samples lie on image edges of the same direction, all six degrees of freedom at once:
/// poses drawn from the prior, then around the best ones with a shrinking spread and a shrinking kernel (an annealed
/// evolution strategy). A nearest-edge iteration takes whatever edge is near; a score over all samples takes the pose
/// on which most of them agree, so texture beside an edge does not capture it. Deterministic.
PoseSearchResult search_pose(const Camera& camera, const PoseGuess& guess, const std::vector<MapEdge>& edges,
                             const std::vector<EdgeSample>& samples, const DirectionalDistanceField& field,
                             const PoseSearchOptions& options);

}  // namespace cpplus
