#include "cpplus/refine/pose_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cpplus/core/random.h"
#include "cpplus/refine/edge_likelihood.h"

namespace cpplus {
namespace {

struct Hypothesis {
  Vector6d x = Vector6d::Zero();  // in standard deviations of the guess
  double score = 0.0;
};

}  // namespace

void PoseSearchOptions::validate() const {
  check_option(poses_per_round >= 2, "poses_per_round", "[2, inf)", poses_per_round);
  check_option(rounds >= 1, "rounds", "[1, inf)", rounds);
  check_option(first_kernel_px > 0, "first_kernel_px", "(0, inf)", first_kernel_px);
  check_option(last_kernel_px > 0, "last_kernel_px", "(0, inf)", last_kernel_px);
  check_option(max_samples >= 1, "max_samples", "[1, inf)", max_samples);
}

void PosePrior::validate() const {
  check_option(rotation_sigma_deg > 0, "rotation_sigma_deg", "(0, inf)", rotation_sigma_deg);
  check_option(translation_sigma_m > 0, "translation_sigma_m", "(0, inf)", translation_sigma_m);
}

Vector6d PosePrior::sigmas() const {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(rotation_sigma_deg * std::numbers::pi / 180.0),
      Eigen::Vector3d::Constant(translation_sigma_m);
  return sigmas;
}

PoseSearchResult search_pose(const Camera& camera, const PoseGuess& guess, const std::vector<MapEdge>& edges,
                             const std::vector<EdgeSample>& samples, const DirectionalDistanceField& field,
                             const PoseSearchOptions& options) {
  EdgeLikelihood likelihood(camera, guess.camera_from_map, edges, samples, field, options.max_samples);
  PoseSearchResult result;
  result.camera_from_map = guess.camera_from_map;
  if (likelihood.empty()) return result;
  // Perturbations in standard deviations of the guess, so that directions in which it is sure are not searched.
  const Matrix6d root = guess.root();
  Random random(options.seed);
  const auto draw = [&](double scale) {
    Vector6d step;
    for (int i = 0; i < 6; ++i) step(i) = scale * random.normal();
    return step;
  };

  const size_t count = static_cast<size_t>(options.poses_per_round);
  const size_t num_elites = std::max<size_t>(1, count / 20);
  std::vector<Hypothesis> elites(1);
  double spread = 1.0;
  for (int round = 0; round < options.rounds; ++round) {
    const double progress = options.rounds > 1 ? static_cast<double>(round) / (options.rounds - 1) : 1.0;
    likelihood.set_kernel(options.first_kernel_px *
                          std::pow(options.last_kernel_px / options.first_kernel_px, progress));
    std::vector<Hypothesis> poses = elites;
    while (poses.size() < count) {
      const Hypothesis& parent = elites[random.below(elites.size())];
      poses.push_back({parent.x + draw(spread), 0.0});
    }
    std::vector<Vector6d> deltas;
    for (const Hypothesis& pose : poses) deltas.push_back(root * pose.x);
    const std::vector<double> ratios = likelihood.log_ratios(deltas);
    for (size_t i = 0; i < poses.size(); ++i) poses[i].score = ratios[i] - 0.5 * poses[i].x.squaredNorm();
    std::stable_sort(poses.begin(), poses.end(),
                     [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
    elites.assign(poses.begin(), poses.begin() + static_cast<std::ptrdiff_t>(std::min(num_elites, poses.size())));
    spread *= round == 0 ? 0.4 : 0.6;
  }
  const Vector6d best = root * elites.front().x;
  result.start_score = likelihood.log_ratio(Vector6d::Zero());
  result.best_score = likelihood.log_ratio(best);
  result.camera_from_map = perturb_camera(guess.camera_from_map, best);
  return result;
}

}  // namespace cpplus
