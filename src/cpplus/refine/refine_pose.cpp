#include "cpplus/refine/refine_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "cpplus/refine/degeneracy.h"
#include "cpplus/refine/edge_likelihood.h"
#include "cpplus/refine/edge_match.h"
#include "cpplus/refine/edgel_index.h"
#include "cpplus/refine/match_weight.h"
#include "cpplus/refine/pose_solver.h"
#include "cpplus/refine/projected_sample.h"
#include "cpplus/refine/unproven_directions.h"

namespace cpplus {
namespace {

constexpr int kFieldCellPx = 4;

// Of each sample that a pose sees the image edge nearest to it.
struct NearestEdges {
  std::vector<SampleInImage> samples;
  std::vector<std::optional<uint32_t>> edgels;
};

class PoseRefiner {
 public:
  PoseRefiner(const Camera& camera, const Rigid3& coarse, const PoseGuess& guess, const std::vector<MapEdge>& edges,
              const std::vector<EdgeSample>& samples, const ImageEdges& image_edges, const RefinePoseOptions& options)
      : camera_(camera),
        coarse_(coarse),
        guess_(guess),
        edges_(edges),
        index_(image_edges, options.max_angle_deg),
        field_(image_edges, kFieldCellPx, 3.0 * options.search.first_kernel_px),
        options_(options) {
    split(samples);
  }

  RefinePoseResult run() {
    RefinePoseResult result;
    result.camera_from_map = coarse_;
    result.candidate_camera_from_map = coarse_;
    result.num_samples = static_cast<int>(all_.size());
    result.before = residual_of(look_up(all_, coarse_, options_.first_radius_px));
    result.held_out_before = result.before;  // every edge is held out once
    if (result.num_samples < options_.min_samples) return keep(std::move(result), "too few map edges in view");

    Rigid3 pose = guess_.camera_from_map;
    if (options_.search.enabled) {
      pose = search_pose(camera_, guess_, edges_, all_, field_, options_.search).camera_from_map;
    }
    for (int round = 0; round < options_.max_iterations; ++round) {
      const std::vector<EdgeMatch> matches = matches_of(look_up(all_, pose, radius_of(round)), radius_of(round));
      if (static_cast<int>(matches.size()) < options_.min_samples) break;
      pose = minimise(pose, matches, &result.iterations);
    }
    NearestEdges nearest = look_up(all_, pose, options_.first_radius_px);
    std::vector<EdgeMatch> matches = matches_of(nearest, options_.last_radius_px);
    Matrix6d information = edge_information(matches, options_.loss_scale);
    const PoseDirections unproven = unproven_directions_at(nearest, information);
    if (unproven.cols() > 0) {
      pose = leave_to_guess(pose, without(unproven, information));
      nearest = look_up(all_, pose, options_.first_radius_px);
      matches = matches_of(nearest, options_.last_radius_px);
      information = without(unproven, edge_information(matches, options_.loss_scale));
    }
    result.candidate_camera_from_map = pose;
    result.after = residual_of(nearest);
    result.held_out_after = cross_validate(pose, nearest);
    judge(pose, matches, information, &result);
    return result;
  }

 private:
  // Whole edges, and all pieces of an edge, go into one fold: samples of one edge fit together. Dealt out in the order
  // of their samples, so that every fold has long and short ones.
  void split(const std::vector<EdgeSample>& samples) {
    std::map<uint32_t, size_t> samples_of_group;
    for (const EdgeSample& sample : samples) ++samples_of_group[edges_[sample.edge].group];
    std::vector<std::pair<size_t, uint32_t>> groups;
    for (const auto& [group, count] : samples_of_group) groups.emplace_back(count, group);
    std::stable_sort(groups.begin(), groups.end(), [](const auto& x, const auto& y) { return x.first > y.first; });
    const size_t num_folds = static_cast<size_t>(options_.folds);
    std::map<uint32_t, size_t> fold_of_group;
    for (size_t i = 0; i < groups.size(); ++i) fold_of_group[groups[i].second] = i % num_folds;
    for (size_t fold = 0; fold < num_folds; ++fold) {
      fold_begin_.push_back(all_.size());
      std::copy_if(samples.begin(), samples.end(), std::back_inserter(all_),
                   [&](const EdgeSample& sample) { return fold_of_group[edges_[sample.edge].group] == fold; });
    }
    fold_begin_.push_back(all_.size());
  }

  using Samples = std::span<const EdgeSample>;

  Samples fold(size_t k) const { return Samples(all_).subspan(fold_begin_[k], fold_begin_[k + 1] - fold_begin_[k]); }

  // Each fold judged by the pose that the other folds give, from the common solution and the edges nearest to it.
  EdgeResidual cross_validate(const Rigid3& pose, const NearestEdges& nearest) const {
    std::vector<double> distances;
    EdgeResidual residual;
    for (size_t k = 0; k + 1 < fold_begin_.size(); ++k) {
      int iterations = 0;
      const Rigid3 judged = minimise(pose, matches_of(nearest, options_.first_radius_px, fold(k)), &iterations);
      measure(look_up(fold(k), judged, options_.first_radius_px), &distances, &residual);
    }
    return summarise(std::move(distances), residual);
  }

  double radius_of(int round) const {
    if (options_.max_iterations == 1) return options_.last_radius_px;
    const double progress = static_cast<double>(round) / (options_.max_iterations - 1);
    return options_.first_radius_px * std::pow(options_.last_radius_px / options_.first_radius_px, progress);
  }

  // What a pose sees of the samples, each with the image edge nearest to it within the radius.
  NearestEdges look_up(Samples samples, const Rigid3& pose, double radius_px) const {
    NearestEdges nearest;
    nearest.samples.reserve(samples.size());
    nearest.edgels.reserve(samples.size());
    const SampleProjector projector(camera_, pose);
    for (const EdgeSample& sample : samples) {
      const auto projected = projector.project(sample);
      if (!projected) continue;
      nearest.samples.push_back({&sample, *projected});
      nearest.edgels.push_back(index_.nearest_along(projected->pixel, projected->normal, radius_px));
    }
    return nearest;
  }

  // The samples with an image edge within the radius, but for some.
  std::vector<EdgeMatch> matches_of(const NearestEdges& nearest, double radius_px, Samples without = {}) const {
    std::vector<EdgeMatch> matches;
    for (size_t i = 0; i < nearest.samples.size(); ++i) {
      const auto& [sample, projected] = nearest.samples[i];
      if (!nearest.edgels[i] || (sample >= without.data() && sample < without.data() + without.size())) continue;
      // Across the projected edge: an edgel's own normal is 2 degrees noisy, which would pass for evidence along
      // the edge where all edges are parallel.
      EdgeMatch m;
      m.pixel = index_.edgel(*nearest.edgels[i]).pixel.cast<double>();
      m.normal = projected.normal;
      if (std::abs(m.normal.dot(m.pixel - projected.pixel)) >= radius_px) continue;
      m.x_in_map = sample->x_in_map;
      m.edge = sample->edge;
      m.projected = projected;
      const MapEdge& edge = edges_[sample->edge];
      weigh_match(edge.covariance, edge.length(), *sample, options_.image_sigma_px, options_.edge_sigma_px, &m);
      matches.push_back(m);
    }
    return matches;
  }

  Rigid3 minimise(const Rigid3& pose, const std::vector<EdgeMatch>& matches, int* iterations) const {
    const PoseSolution solution = solve_pose(camera_, pose, matches, guess_, options_.loss_scale, kMaxPoseIterations);
    *iterations += solution.iterations;
    return solution.camera_from_map;
  }

  Matrix6d without(const PoseDirections& directions, const Matrix6d& information) const {
    EvidenceTerm term;
    term.h = information;
    free_directions(directions, guess_.sigmas(), &term);
    return term.h;
  }

  PoseDirections unproven_directions_at(const NearestEdges& nearest, const Matrix6d& information) const {
    std::optional<EdgeLikelihood> likelihood;  // mostly not asked for
    return unproven_directions(information, guess_.sigmas(), options_.min_log_gain, [&](const Vector6d& delta) {
      if (!likelihood) {
        likelihood.emplace(nearest.samples, edges_, field_);
        likelihood->set_kernel(options_.search.last_kernel_px);
      }
      return likelihood->log_ratio(delta);
    });
  }

  // The pose between that of the edges, which hold that information, and the guess.
  Rigid3 leave_to_guess(const Rigid3& pose, const Matrix6d& information) const {
    const Matrix6d of_guess = guess_.covariance.inverse();
    const Vector6d to_guess = camera_difference(pose, guess_.camera_from_map);
    return perturb_camera(pose, (information + of_guess).ldlt().solve(of_guess * to_guess));
  }

  EdgeResidual residual_of(const NearestEdges& nearest) const {
    std::vector<double> distances;
    EdgeResidual residual;
    measure(nearest, &distances, &residual);
    return summarise(std::move(distances), residual);
  }

  // Adds what the samples say, looked up within the first radius.
  void measure(const NearestEdges& nearest, std::vector<double>* distances, EdgeResidual* residual) const {
    for (size_t i = 0; i < nearest.samples.size(); ++i) {
      double distance = options_.first_radius_px;
      if (nearest.edgels[i]) {
        const ImageEdgel& edgel = index_.edgel(*nearest.edgels[i]);
        const Eigen::Vector2d offset = edgel.pixel.cast<double>() - nearest.samples[i].projected.pixel;
        distance = std::abs(edgel.normal.cast<double>().dot(offset));
        ++residual->num_matches;
      }
      distances->push_back(distance);
    }
    EdgeLikelihood likelihood(nearest.samples, edges_, field_);
    likelihood.set_kernel(options_.search.last_kernel_px);
    residual->log_ratio += likelihood.log_ratio_fitted();
  }

  EdgeResidual summarise(std::vector<double> distances, const EdgeResidual& measured) const {
    EdgeResidual residual = summarise_distances(std::move(distances), options_.last_radius_px);
    residual.num_matches = measured.num_matches;
    residual.log_ratio = measured.log_ratio;
    return residual;
  }

  void judge(const Rigid3& pose, const std::vector<EdgeMatch>& matches, const Matrix6d& information,
             RefinePoseResult* result) const {
    result->num_matches = static_cast<int>(matches.size());
    result->num_edges = count_edges(matches);
    result->information = information;
    const Degeneracy degeneracy = analyse_information(result->information, guess_.sigmas());
    result->covariance = degeneracy.covariance;
    result->information_eigenvalues = degeneracy.eigenvalues;
    result->weak_directions = degeneracy.weak_directions;
    const double gain = result->held_out_after.log_ratio - result->held_out_before.log_ratio + guess_gain(pose);
    if (result->num_matches < options_.min_samples || result->num_edges < options_.min_edges) {
      result->reason = "too few matched edges";
    } else if (degeneracy.weak_directions.size() >= 4) {
      result->reason = "the matched edges determine too few directions";
    } else if (result->held_out_after.log_ratio < options_.min_log_ratio) {
      result->reason = "the map's edges do not lie on image edges more than by chance";
    } else if (gain < options_.min_log_gain) {
      result->reason = "held-out edges do not fit better than before";
    }
    if (!result->reason.empty()) return;
    result->status = RefineStatus::kRefined;
    result->camera_from_map = pose;
  }

  // A guess that is not the coarse pose comes from other images: evidence on which of two poses is the better one.
  double guess_gain(const Rigid3& pose) const {
    const double to_coarse = guess_.squared_distance(coarse_);
    if (to_coarse < 1e-12) return 0.0;
    constexpr double kDegrees = 4.0;  // Student's t: neighbours may be wrong
    return 0.5 * (kDegrees + 6.0) *
           (std::log1p(to_coarse / kDegrees) - std::log1p(guess_.squared_distance(pose) / kDegrees));
  }

  static RefinePoseResult keep(RefinePoseResult result, const char* reason) {
    result.reason = reason;
    return result;
  }

  const Camera& camera_;
  const Rigid3 coarse_;
  const PoseGuess guess_;
  const std::vector<MapEdge>& edges_;
  const EdgelIndex index_;
  const DirectionalDistanceField field_;
  const RefinePoseOptions& options_;
  std::vector<EdgeSample> all_;  // by fold
  std::vector<size_t> fold_begin_;
};

}  // namespace

void RefinePoseOptions::validate() const {
  prior.validate();
  search.validate();
  check_option(max_iterations >= 1, "max_iterations", "[1, inf)", max_iterations);
  check_option(first_radius_px > 0, "first_radius_px", "(0, inf)", first_radius_px);
  check_option(last_radius_px > 0, "last_radius_px", "(0, inf)", last_radius_px);
  check_option(max_angle_deg > 0 && max_angle_deg < 90, "max_angle_deg", "(0, 90)", max_angle_deg);
  check_option(image_sigma_px > 0, "image_sigma_px", "(0, inf)", image_sigma_px);
  check_option(edge_sigma_px >= 0, "edge_sigma_px", "[0, inf)", edge_sigma_px);
  check_option(loss_scale > 0, "loss_scale", "(0, inf)", loss_scale);
  check_option(folds >= 2, "folds", "[2, inf)", folds);
  check_option(min_log_gain >= 0, "min_log_gain", "[0, inf)", min_log_gain);
  check_option(max_predicted_shift_px > 0, "max_predicted_shift_px", "(0, inf)", max_predicted_shift_px);
  check_option(max_predicted_share >= 0 && max_predicted_share <= 1, "max_predicted_share", "[0, 1]",
               max_predicted_share);
  check_option(min_edges >= 1, "min_edges", "[1, inf)", min_edges);
  check_option(min_samples >= 1, "min_samples", "[1, inf)", min_samples);
}

RefinePoseResult refine_pose(const Camera& camera, const Rigid3& coarse_camera_from_map, const PoseGuess& guess,
                             const std::vector<MapEdge>& edges, const std::vector<EdgeSample>& samples,
                             const ImageEdges& image_edges, const RefinePoseOptions& options) {
  return PoseRefiner(camera, coarse_camera_from_map, guess, edges, samples, image_edges, options).run();
}

}  // namespace cpplus
