#include "cpplus/refine/pose_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "cpplus/core/random.h"
#include "cpplus/refine/edge_likelihood.h"

namespace cpplus {
namespace {

struct Hypothesis {
  Vector6d x = Vector6d::Zero();  // in standard deviations of the guess
  double log_ratio = 0.0;         // of the samples looked at
  double score = 0.0;
};

bool is_better(const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; }

// The best num_elites poses, best first. All are looked at with a part of the samples, then the better half with
// another one, and so on: which poses are bad few samples tell.
void keep_best(const EdgeLikelihood& likelihood, const Matrix6d& root, size_t num_elites,
               std::vector<Hypothesis>* poses) {
  const double num_parts = static_cast<double>(likelihood.num_parts());
  for (size_t part = 0; part < likelihood.num_parts(); ++part) {
    for (Hypothesis& pose : *poses) {
      pose.log_ratio += likelihood.log_ratio_of_part(root * pose.x, part);
      pose.score = pose.log_ratio * num_parts / static_cast<double>(part + 1) - 0.5 * pose.x.squaredNorm();
    }
    if (part + 1 == likelihood.num_parts()) break;
    const size_t half = std::min(poses->size(), std::max(num_elites, poses->size() / 2));
    std::nth_element(poses->begin(), poses->begin() + static_cast<std::ptrdiff_t>(half - 1), poses->end(), is_better);
    poses->resize(half);
  }
  std::stable_sort(poses->begin(), poses->end(), is_better);
  poses->resize(std::min(num_elites, poses->size()));
}

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
    std::vector<Hypothesis> poses;
    for (const Hypothesis& elite : elites) poses.push_back({elite.x});
    while (poses.size() < count) poses.push_back({elites[random.below(elites.size())].x + draw(spread)});
    keep_best(likelihood, root, num_elites, &poses);
    elites = std::move(poses);
    spread *= round == 0 ? 0.4 : 0.6;
  }
  const Vector6d best = root * elites.front().x;
  result.start_score = likelihood.log_ratio(Vector6d::Zero());
  result.best_score = likelihood.log_ratio(best);
  result.camera_from_map = perturb_camera(guess.camera_from_map, best);
  return result;
}

}  // namespace cpplus
