#pragma once

#include <limits>
#include <string>
#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/core/options.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/image_edge.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/edge_residual.h"
#include "cpplus/refine/edge_samples.h"
#include "cpplus/refine/pose_search.h"

namespace cpplus {

struct RefinePoseOptions {
  PosePrior prior;
  PoseSearchOptions search;
  /// Rounds of matching and minimising. [1, inf)
  int max_iterations = 3;
  /// Samples look for an image edge this far in the first and in the last round, pixels. (0, inf)
  double first_radius_px = 8.0;
  double last_radius_px = 3.0;
  /// Largest angle between a projected map edge and the image edge it matches, degrees. (0, 90)
  double max_angle_deg = 15.0;
  /// Standard deviation of an image edge's position, one sample, pixels. (0, inf)
  double image_sigma_px = 0.5;
  /// What all samples of an edge have in common (shading, rounded corners), pixels. [0, inf)
  double edge_sigma_px = 0.6;
  /// Scale of the Cauchy loss in standard deviations. (0, inf)
  double loss_scale = 1.5;
  /// The edges are dealt into so many folds; each is judged by a pose that the others give. [2, inf)
  int folds = 4;
  /// Fewest matched edges and samples for a result. [1, inf)
  int min_edges = 5;
  int min_samples = 30;
  /// Least logarithm of the likelihood ratio of the held-out samples to edges put at random. (-inf, inf)
  double min_log_ratio = 30.0;
  /// The same to the coarse pose: what the best of many poses gains by chance. [0, inf)
  double min_log_gain = 10.0;
  /// Where images are solved together: a pose is believed when the surface that the image sees is expected, by the
  /// covariance, to be off by no more than this, pixels. (0, inf)
  double max_predicted_shift_px = 5.0;
  /// Or by no more than this share of what the pose moved that surface by: it is a better pose than the coarse one all
  /// the same. Of 0.7 times that where a direction is not known by the image's own edges. [0, 1]
  double max_predicted_share = 0.75;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor.group("prior", prior);
    visitor.group("search", search);
    visitor("max_iterations", max_iterations, "Rounds of matching and minimising.");
    visitor("first_radius_px", first_radius_px, "Samples look for an image edge this far in the first round, pixels.");
    visitor("last_radius_px", last_radius_px, "The same in the last round, pixels.");
    visitor("max_angle_deg", max_angle_deg, "Largest angle between a map edge and the image edge it matches, degrees.");
    visitor("image_sigma_px", image_sigma_px, "Standard deviation of an image edge's position, pixels.");
    visitor("edge_sigma_px", edge_sigma_px, "What all samples of an edge have in common, pixels.");
    visitor("loss_scale", loss_scale, "Scale of the Cauchy loss in standard deviations.");
    visitor("folds", folds, "Folds of edges, each judged by a pose that the others give.");
    visitor("min_edges", min_edges, "Fewest matched edges for a result.");
    visitor("min_samples", min_samples, "Fewest matched samples for a result.");
    visitor("min_log_ratio", min_log_ratio, "Least log likelihood ratio of held-out edges to edges put at random.");
    visitor("min_log_gain", min_log_gain, "The same to the coarse pose: more than the best of many gains by chance.");
    visitor("max_predicted_shift_px", max_predicted_shift_px,
            "Poses solved together are believed when expected to be off by no more than this, pixels.");
    visitor("max_predicted_share", max_predicted_share,
            "Or by no more than this share of its way from the coarse pose. [0, 1]");
  }
};

enum class RefineStatus { kRefined, kKeptCoarse };

struct RefinePoseResult {
  RefineStatus status = RefineStatus::kKeptCoarse;
  std::string reason;                // why the coarse pose was kept, or what is to be known of a refined one
  Rigid3 camera_from_map;            // refined, or the coarse one unchanged
  Rigid3 candidate_camera_from_map;  // the best pose found, accepted or not
  EdgeResidual before, after;        // all samples
  EdgeResidual held_out_before, held_out_after;  // each sample by a pose that it had no part in
  int num_edges = 0;                             // with at least one match
  int num_samples = 0;
  int num_matches = 0;
  int iterations = 0;  // of the minimiser, all rounds
  /// Of the perturbation in geometry/rigid3.h: rad, rad, rad, m, m, m.
  Matrix6d covariance = Matrix6d::Zero();
  Matrix6d information = Matrix6d::Zero();  // of the data alone, inverse units
  /// Eigenvalues, ascending, of the data's information in units of the prior's (sigma_prior^2 * information): below 1
  /// the prior knows a direction better than the edges.
  Vector6d information_eigenvalues = Vector6d::Zero();
  std::vector<std::string> weak_directions;
  /// By how many pixels the surface that the image sees is expected to be off, by the covariance; infinite where
  /// nothing says so, as of an image on its own.
  double predicted_shift_px = std::numeric_limits<double>::infinity();
};

/// Aligns one image with the map's edges: minimises, along the image edges' normals, the distance between projected
/// edge samples and the image edges they match (Eq. 4-5 of Cui & Schwertfeger 2022) with the guess as a prior, so that
/// directions without evidence stay where they were. The result counts only if edges that were held out are explained
/// better than by the coarse pose.
RefinePoseResult refine_pose(const Camera& camera, const Rigid3& coarse_camera_from_map, const PoseGuess& guess,
                             const std::vector<MapEdge>& edges, const std::vector<EdgeSample>& samples,
                             const ImageEdges& image_edges, const RefinePoseOptions& options);

}  // namespace cpplus
