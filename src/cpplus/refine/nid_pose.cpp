#include "cpplus/refine/nid_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

#include "cpplus/refine/nelder_mead.h"

namespace cpplus {
namespace {

double entropy(const auto& shares) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < shares.size(); ++i) {
    const double p = shares(i);
    if (p > 0) sum -= p * std::log(p);
  }
  return sum;
}

int bin_of(double value, int bins) { return std::clamp(static_cast<int>(value * bins), 0, bins - 1); }

// Bin of each grey level.
std::array<int, 256> gray_bins(int bins) {
  std::array<int, 256> table;
  for (size_t level = 0; level < table.size(); ++level) table[level] = bin_of(static_cast<double>(level) / 256.0, bins);
  return table;
}

// Weights of the pixels at -1, 0, 1, 2 from the floor, for a place t in [0, 1) beyond it; their sum is 1.
std::array<double, 4> cubic_weights(double t) {
  const double s = 1.0 - t;
  return {s * s * s / 6.0, (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0, (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0,
          t * t * t / 6.0};
}

Vector6d simplex_steps(const NidOptions& options, int round) {
  Vector6d steps;
  steps.head<3>().setConstant(options.rotation_step_deg * std::numbers::pi / 180.0);
  steps.tail<3>().setConstant(options.translation_step_m);
  return std::ldexp(1.0, -round) * steps;
}

}  // namespace

void NidOptions::validate() const {
  check_option(bins >= 2 && bins <= 256, "bins", "[2, 256]", bins);
  check_option(rounds >= 1, "rounds", "[1, inf)", rounds);
  check_option(max_evaluations >= 8, "max_evaluations", "[8, inf)", max_evaluations);
  check_option(rotation_step_deg > 0, "rotation_step_deg", "(0, inf)", rotation_step_deg);
  check_option(translation_step_m > 0, "translation_step_m", "(0, inf)", translation_step_m);
  check_option(max_distance_m > 0, "max_distance_m", "(0, inf)", max_distance_m);
  check_option(occlusion_margin_m >= 0, "occlusion_margin_m", "[0, inf)", occlusion_margin_m);
  check_option(max_points >= 1, "max_points", "[1, inf)", max_points);
  check_option(min_points >= 1, "min_points", "[1, inf)", min_points);
}

std::vector<float> equalise_intensities(const std::vector<float>& intensities) {
  std::vector<float> sorted;
  std::copy_if(intensities.begin(), intensities.end(), std::back_inserter(sorted),
               [](float value) { return !std::isnan(value); });
  std::sort(sorted.begin(), sorted.end());
  std::vector<float> result;
  result.reserve(intensities.size());
  for (const float value : intensities) {
    if (std::isnan(value)) {
      result.push_back(value);
      continue;
    }
    const auto [low, high] = std::equal_range(sorted.begin(), sorted.end(), value);
    const double twice_rank = static_cast<double>((low - sorted.begin()) + (high - sorted.begin()));
    result.push_back(static_cast<float>(0.5 * twice_rank / static_cast<double>(sorted.size())));
  }
  return result;
}

double normalised_information_distance(const Eigen::MatrixXd& joint_histogram) {
  const double sum = joint_histogram.sum();
  if (!(sum > 0)) return 1.0;
  const Eigen::MatrixXd joint = joint_histogram / sum;
  const double joint_entropy = entropy(joint.reshaped());
  if (joint_entropy < 1e-12) return 1.0;
  const double distance = 2.0 * joint_entropy - entropy(joint.rowwise().sum()) - entropy(joint.colwise().sum());
  return std::clamp(distance / joint_entropy, 0.0, 1.0);
}

double nid_at(const std::vector<NidPoint>& points, const Camera& camera, const Rigid3& camera_from_map,
              const GrayImage& image, int bins) {
  const std::array<int, 256> bin_of_gray = gray_bins(bins);
  const Eigen::Matrix3d rotation = camera_from_map.rotation.toRotationMatrix();
  Eigen::MatrixXd histogram = Eigen::MatrixXd::Zero(bins, bins);  // brightness x intensity
  size_t inside = 0;
  for (const NidPoint& point : points) {
    const auto pixel = camera.project(rotation * point.x_in_map + camera_from_map.translation);
    if (!pixel || !camera.in_image(*pixel, 2.0)) continue;
    ++inside;
    const int x = static_cast<int>(pixel->x());
    const int y = static_cast<int>(pixel->y());
    const std::array<double, 4> weights_x = cubic_weights(pixel->x() - x);
    const std::array<double, 4> weights_y = cubic_weights(pixel->y() - y);
    auto votes = histogram.col(bin_of(point.intensity, bins));
    for (size_t j = 0; j < 4; ++j) {
      const uint8_t* row = &image.at(x - 1, y - 1 + static_cast<int>(j));
      for (size_t i = 0; i < 4; ++i) votes(bin_of_gray[row[i]]) += weights_y[j] * weights_x[i];
    }
  }
  return 2 * inside < points.size() ? 1.0 : normalised_information_distance(histogram);
}

NidResult refine_pose_nid(const Camera& camera, const Rigid3& coarse_camera_from_map, const GrayImage& image,
                          const std::function<std::vector<NidPoint>(const Rigid3& camera_from_map)>& visible_points,
                          const NidOptions& options) {
  NidResult result;
  result.camera_from_map = coarse_camera_from_map;
  Rigid3 pose = coarse_camera_from_map;
  for (int round = 0; round < options.rounds; ++round) {
    const std::vector<NidPoint> points = visible_points(pose);
    result.num_points = static_cast<int>(points.size());
    if (result.num_points < options.min_points) {
      result.reason = "too few map points in view";
      return result;
    }
    const auto cost = [&](const Vector6d& delta) {
      return nid_at(points, camera, perturb_camera(pose, delta), image, options.bins);
    };
    NelderMeadOptions simplex;
    simplex.max_evaluations = options.max_evaluations;
    const NelderMeadResult best = minimise_nelder_mead(cost, Vector6d::Zero(), simplex_steps(options, round), simplex);
    pose = perturb_camera(pose, best.x);
    result.evaluations += best.evaluations;
    result.before = nid_at(points, camera, coarse_camera_from_map, image, options.bins);
    result.after = best.cost;
  }
  result.improved = result.after < result.before;
  if (result.improved) {
    result.camera_from_map = pose;
  } else {
    result.reason = "the information distance does not fall";
  }
  return result;
}

}  // namespace cpplus
