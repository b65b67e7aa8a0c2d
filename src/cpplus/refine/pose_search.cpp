#include "cpplus/refine/pose_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "cpplus/core/random.h"
#include "cpplus/refine/projected_sample.h"

namespace cpplus {
namespace {

using Vector6f = Eigen::Matrix<float, 6, 1>;

struct Hypothesis {
  Vector6d delta = Vector6d::Zero();
  double score = 0.0;
};

struct LinearSample {
  Eigen::Vector2f pixel;
  Eigen::Matrix<float, 2, 6> jacobian;
  Eigen::Vector2f normal;
  float weight;
  float map_variance;  // of the map edge's position across itself, square pixels
  float inverse_kernel = 0.0f;
  float background = 1.0f;  // score of a sample put here at random
  int bin;
};

// Smooth bump: 1 at distance 0, 0 from three kernel widths on; the width of a Gaussian kernel without its exp().
float bump(float distance, float inverse_kernel) {
  const float x = distance * inverse_kernel;
  const float rest = 1.0f - x * x / 9.0f;
  return rest > 0.0f ? rest * rest * rest * rest : 0.0f;
}

// The score of poses near one pose, about which the projection is linearised.
class Scorer {
 public:
  Scorer(const Camera& camera, const Rigid3& camera_from_map, const std::vector<MapEdge>& edges,
         const std::vector<EdgeSample>& samples, const DirectionalDistanceField& field, int max_samples)
      : field_(field) {
    const size_t step =
        std::max<size_t>(1, (samples.size() + static_cast<size_t>(max_samples) - 1) / static_cast<size_t>(max_samples));
    for (size_t i = 0; i < samples.size(); i += step) {
      const auto projected = project_sample(camera, camera_from_map, samples[i]);
      if (!projected) continue;
      LinearSample s;
      s.pixel = projected->pixel.cast<float>();
      s.jacobian = projected->d_pixel_d_delta.cast<float>();
      s.normal = projected->normal.cast<float>();
      const Eigen::RowVector3d d_distance_d_point = projected->normal.transpose() * projected->d_pixel_d_point;
      s.map_variance = static_cast<float>(
          (d_distance_d_point * edges[samples[i].edge].covariance * d_distance_d_point.transpose()).value());
      s.bin = DirectionalDistanceField::bin_of(projected->normal);
      s.weight =
          static_cast<float>(step) * std::min(1.0f, kIndependentSamples / static_cast<float>(samples[i].edge_samples));
      linear_.push_back(s);
    }
  }

  // What a sample scores by chance depends on how much image texture of its direction is around it.
  void set_kernel(double kernel_px) {
    for (LinearSample& s : linear_) {
      s.inverse_kernel = 1.0f / std::sqrt(static_cast<float>(kernel_px * kernel_px) + s.map_variance);
      float sum = 0.0f;
      for (int k = -kBackgroundSteps; k <= kBackgroundSteps; ++k) {
        const float offset = static_cast<float>(k) * kBackgroundReachPx / kBackgroundSteps;
        sum += bump(field_.distance(s.pixel + offset * s.normal, s.bin), s.inverse_kernel);
      }
      s.background = std::max(0.03f, sum / (2 * kBackgroundSteps + 1));
    }
  }

  // Logarithm of the likelihood ratio "the edge is seen here" to "by chance", summed: each sample is a mixture of an
  // inlier, whose distance follows the kernel, and an outlier.
  double score(const Vector6d& delta) const {
    const Vector6f d = delta.cast<float>();
    float sum = 0.0f;
    for (const LinearSample& s : linear_) {
      const float value = bump(field_.distance(s.pixel + s.jacobian * d, s.bin), s.inverse_kernel);
      sum += s.weight * std::log(1.0f - kInlierShare + kInlierShare * value / s.background);
    }
    return sum;
  }

  bool empty() const { return linear_.empty(); }

 private:
  static constexpr float kInlierShare = 0.6f;
  // Samples of one edge agree with each other: together they count as this many.
  static constexpr float kIndependentSamples = 4.0f;
  static constexpr int kBackgroundSteps = 8;
  static constexpr float kBackgroundReachPx = 32.0f;

  const DirectionalDistanceField& field_;
  std::vector<LinearSample> linear_;
};

double prior_penalty(const Vector6d& delta, const Vector6d& sigmas) {
  return 0.5 * delta.cwiseQuotient(sigmas).squaredNorm();
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

PoseSearchResult search_pose(const Camera& camera, const Rigid3& camera_from_map, const std::vector<MapEdge>& edges,
                             const std::vector<EdgeSample>& samples, const DirectionalDistanceField& field,
                             const PosePrior& prior, const PoseSearchOptions& options) {
  Scorer scorer(camera, camera_from_map, edges, samples, field, options.max_samples);
  PoseSearchResult result;
  result.camera_from_map = camera_from_map;
  if (scorer.empty()) return result;
  const Vector6d sigmas = prior.sigmas();
  Random random(options.seed);
  const auto draw = [&](double scale) {
    Vector6d step;
    for (int i = 0; i < 6; ++i) step(i) = scale * sigmas(i) * random.normal();
    return step;
  };

  const size_t count = static_cast<size_t>(options.poses_per_round);
  const size_t num_elites = std::max<size_t>(1, count / 20);
  std::vector<Hypothesis> elites(1);
  double spread = 1.0;
  for (int round = 0; round < options.rounds; ++round) {
    const double progress = options.rounds > 1 ? static_cast<double>(round) / (options.rounds - 1) : 1.0;
    const double kernel_px =
        options.first_kernel_px * std::pow(options.last_kernel_px / options.first_kernel_px, progress);
    scorer.set_kernel(kernel_px);
    std::vector<Hypothesis> poses = elites;
    while (poses.size() < count) {
      const Hypothesis& parent = elites[random.below(elites.size())];
      poses.push_back({parent.delta + draw(spread), 0.0});
    }
    for (Hypothesis& pose : poses) {
      pose.score = scorer.score(pose.delta) - prior_penalty(pose.delta, sigmas);
    }
    std::stable_sort(poses.begin(), poses.end(),
                     [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
    elites.assign(poses.begin(), poses.begin() + static_cast<std::ptrdiff_t>(std::min(num_elites, poses.size())));
    spread *= round == 0 ? 0.4 : 0.6;
  }
  result.start_score = scorer.score(Vector6d::Zero());
  result.best_score = scorer.score(elites.front().delta);
  result.camera_from_map = perturb_camera(camera_from_map, elites.front().delta);
  return result;
}

}  // namespace cpplus
