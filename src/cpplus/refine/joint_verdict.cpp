#include "cpplus/refine/joint_verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "cpplus/geometry/image_displacement.h"
#include "cpplus/refine/degeneracy.h"
#include "cpplus/refine/pose_solver.h"

namespace cpplus {
namespace {

// Others place an image when they leave it uncertain by so many times what is accepted; their covariance is not
// inflated.
constexpr double kPlacedByOthers = 0.8;
// Log likelihood ratio that random edges hardly reach around one pose; a patch that fits is worth one. (A spot found by
// chance would lie anywhere within tens of pixels; but patches of one surface fit or fail together.)
constexpr double kMinLogRatioOfPlaced = 20.0;
constexpr double kLogRatioOfPatch = 1.0;
// Information of an image's own edges, in that of the prior, along its least known direction, from which on the pose is
// the edges' and not the prior's: half of its standard deviation. Along a corridor, of which hardly anything tells
// where one stands, small errors of edges and patches that all images share make a way of any length: there a pose must
// be the surer.
constexpr double kKnownByEdges = 3.0;
constexpr double kShareUnlessKnown = 0.7;  // of max_predicted_share
constexpr const char* kOnlyNearer = "uncertain, but nearer than the coarse pose";
constexpr const char* kPlaced = "placed by the other images";

EdgeResidual summarise(std::vector<double> distances, double first_radius_px, double last_radius_px) {
  const auto num_matches =
      std::count_if(distances.begin(), distances.end(), [&](double distance) { return distance < first_radius_px; });
  EdgeResidual residual = summarise_distances(std::move(distances), last_radius_px);
  residual.num_matches = static_cast<int>(num_matches);
  return residual;
}

class JointJudge {
 public:
  JointJudge(const Camera& camera, const JointCandidate& candidate, const EdgeResidual& before,
             const RefinePoseOptions& options)
      : camera_(camera), candidate_(candidate), edges_(*candidate.edges), before_(before), options_(options) {}

  RefinePoseResult run() {
    const ImagePose pose = candidate_.pose.image_pose();
    RefinePoseResult result;
    result.camera_from_map = candidate_.coarse_camera_from_map;
    result.candidate_camera_from_map = pose.camera_from_map;
    result.num_samples = static_cast<int>(edges_.num_samples());
    result.after = residual_of(edges_.all(), pose);
    result.held_out_after = cross_validate(pose);
    const std::vector<EdgeMatch> matches = edges_.match(camera_, pose, options_.last_radius_px, noise(), edges_.all());
    result.num_matches = static_cast<int>(matches.size());
    result.num_edges = count_edges(matches);
    result.information = edge_information(matches, options_.loss_scale);
    const Degeneracy degeneracy = analyse_information(result.information, options_.prior.sigmas());
    result.information_eigenvalues = degeneracy.eigenvalues;
    result.weak_directions = degeneracy.weak_directions;
    const double unless_known = degeneracy.eigenvalues.minCoeff() >= kKnownByEdges ? 1.0 : kShareUnlessKnown;
    max_shift_px_ = max_shift(unless_known * shift_from_coarse(pose.camera_from_map));
    result.covariance = candidate_.pose.covariance;
    result.predicted_shift_px = predicted_shift(result.covariance);
    if (result.weak_directions.empty() && result.predicted_shift_px > options_.max_predicted_shift_px) {
      result.weak_directions.push_back(least_known_direction(result.covariance, options_.prior.sigmas()));
    }
    result.held_out_before = before_;
    result.reason = objection(result);
    if (!result.reason.empty()) return result;
    result.status = RefineStatus::kRefined;
    result.camera_from_map = pose.camera_from_map;
    if (result.predicted_shift_px > options_.max_predicted_shift_px) result.reason = kOnlyNearer;
    return result;
  }

  // Without its own edges.
  bool place(RefinePoseResult* result) const {
    const JointPose& joint = candidate_.pose;
    const ImagePose placed(joint.from_others.camera_from_map, joint.motion);
    const double predicted_shift_px = predicted_shift(joint.covariance_from_others);
    const double max_shift_px = max_shift(kShareUnlessKnown * shift_from_coarse(placed.camera_from_map));
    if (candidate_.surface_support < 0 || !(predicted_shift_px <= max_shift_px)) return false;
    result->status = RefineStatus::kRefined;
    result->reason = kPlaced;
    result->camera_from_map = placed.camera_from_map;
    result->covariance = joint.covariance_from_others;
    result->predicted_shift_px = predicted_shift_px;
    result->after = result->held_out_after = residual_of(edges_.all(), placed);  // no edge took part
    return true;
  }

 private:
  // Of the predicted shift, where the pose may be uncertain by a share of `way_px` from the coarse one.
  double max_shift(double way_px) const {
    // Down a corridor all images are equally lost: a way along it is no gain.
    if (!candidate_.most_are_proven) return options_.max_predicted_shift_px;
    return std::max(options_.max_predicted_shift_px, options_.max_predicted_share * way_px);
  }

  EdgeEvidence::Noise noise() const { return {options_.image_sigma_px, options_.edge_sigma_px}; }

  EdgeResidual residual_of(const EdgeEvidence::Selection& selection, const ImagePose& pose) const {
    EdgeResidual residual = summarise(edges_.distances(camera_, pose, options_.first_radius_px, selection),
                                      options_.first_radius_px, options_.last_radius_px);
    residual.log_ratio = edges_.log_ratio(camera_, pose, options_.search.last_kernel_px, selection);
    return residual;
  }

  EdgeResidual cross_validate(const ImagePose& pose) const {
    const std::vector<EdgeEvidence::Selection> folds = edges_.folds(options_.folds);
    std::vector<double> distances;
    double log_ratio = 0.0;
    for (size_t held_out = 0; held_out < folds.size(); ++held_out) {
      EdgeEvidence::Selection others;
      for (size_t fold = 0; fold < folds.size(); ++fold) {
        if (fold != held_out) others.insert(others.end(), folds[fold].begin(), folds[fold].end());
      }
      const std::vector<EdgeMatch> matches = edges_.match(camera_, pose, options_.first_radius_px, noise(), others);
      const ImagePose judged(solve_pose(camera_, pose.camera_from_map, matches, candidate_.pose.from_others,
                                        options_.loss_scale, kMaxPoseIterations)
                                 .camera_from_map,
                             pose.motion);
      const std::vector<double> more = edges_.distances(camera_, judged, options_.first_radius_px, folds[held_out]);
      distances.insert(distances.end(), more.begin(), more.end());
      log_ratio += edges_.log_ratio(camera_, judged, options_.search.last_kernel_px, folds[held_out]);
    }
    EdgeResidual residual = summarise(std::move(distances), options_.first_radius_px, options_.last_radius_px);
    residual.log_ratio = log_ratio;
    return residual;
  }

  // Why the pose is not to be believed; empty if it is.
  const char* objection(const RefinePoseResult& result) const {
    if (!(result.predicted_shift_px <= max_shift_px_)) return "the pose is too uncertain";
    static constexpr const char* kByChance = "the map's edges do not lie on image edges more than by chance";
    // Where the others place the image its own edges need only agree; else they must be more than the best of many
    // poses finds by chance.
    if (predicted_shift(candidate_.pose.from_others.covariance) <= kPlacedByOthers * max_shift_px_) {
      const double log_ratio =
          result.held_out_after.log_ratio + kLogRatioOfPatch * std::max(0, candidate_.surface_support);
      return log_ratio < kMinLogRatioOfPlaced ? kByChance : "";
    }
    if (result.num_matches < options_.min_samples || result.num_edges < options_.min_edges) {
      return "too few matched edges";
    }
    if (result.held_out_after.log_ratio < options_.min_log_ratio) return kByChance;
    if (result.held_out_after.log_ratio - before_.log_ratio < options_.min_log_gain) {
      return "held-out edges do not fit better than before";
    }
    return "";
  }

  // Mean over the surface that the image sees of the standard deviation of its place in the image.
  double predicted_shift(const Matrix6d& covariance) const {
    double sum = 0.0;
    int count = 0;
    EdgeSample sample;
    sample.direction_in_map = Eigen::Vector3d::UnitX();
    for (const Eigen::Vector3d& x : candidate_.surface_in_map) {
      sample.x_in_map = x;
      const auto projected = project_sample(camera_, candidate_.pose.image_pose(), sample);
      if (!projected) continue;
      sum += std::sqrt((projected->d_pixel_d_delta * covariance * projected->d_pixel_d_delta.transpose()).trace());
      ++count;
    }
    return count == 0 ? std::numeric_limits<double>::infinity() : sum / count;
  }

  double shift_from_coarse(const Rigid3& camera_from_map) const {
    return mean_displacement_px(camera_, candidate_.surface_in_map, candidate_.coarse_camera_from_map, camera_from_map);
  }

  const Camera& camera_;
  const JointCandidate& candidate_;
  const EdgeEvidence& edges_;
  const EdgeResidual before_;
  const RefinePoseOptions& options_;
  double max_shift_px_ = 0.0;  // that may be expected of a pose that is believed
};

}  // namespace

RefinePoseResult judge_joint_pose(const Camera& camera, const JointCandidate& candidate,
                                  const EdgeResidual& held_out_before, const RefinePoseOptions& options) {
  return JointJudge(camera, candidate, held_out_before, options).run();
}

bool place_by_others(const Camera& camera, const JointCandidate& candidate, const RefinePoseOptions& options,
                     RefinePoseResult* result) {
  return JointJudge(camera, candidate, result->held_out_before, options).place(result);
}

}  // namespace cpplus
