#include "cpplus/refine/edge_likelihood.h"

#include <algorithm>
#include <cmath>

#include "cpplus/refine/projected_sample.h"

namespace cpplus {
namespace {

// Share of the map's edges that an image shows as edges.
constexpr float kInlierShare = 0.6f;
// Samples of one edge agree with each other: together they count as this many.
constexpr float kIndependentSamples = 4.0f;
constexpr int kBackgroundSteps = 8;
constexpr float kBackgroundReachPx = 32.0f;
constexpr float kMinBackground = 0.03f;

// Smooth bump: 1 at distance 0, 0 from three kernel widths on; the width of a Gaussian kernel without its exp().
float bump(float distance, float inverse_kernel) {
  const float x = distance * inverse_kernel;
  const float rest = 1.0f - x * x / 9.0f;
  return rest > 0.0f ? rest * rest * rest * rest : 0.0f;
}

}  // namespace

EdgeLikelihood::EdgeLikelihood(const Camera& camera, const Rigid3& camera_from_map, const std::vector<MapEdge>& edges,
                               const std::vector<EdgeSample>& samples, const DirectionalDistanceField& field,
                               int max_samples)
    : field_(field) {
  const size_t most = static_cast<size_t>(std::max(1, max_samples));
  const size_t step = std::max<size_t>(1, (samples.size() + most - 1) / most);
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
    s.kind = edges[samples[i].edge].kind;
    samples_.push_back(s);
  }
}

void EdgeLikelihood::set_kernel(double kernel_px) {
  for (LinearSample& s : samples_) {
    s.inverse_kernel = 1.0f / std::sqrt(static_cast<float>(kernel_px * kernel_px) + s.map_variance);
    float sum = 0.0f;
    for (int k = -kBackgroundSteps; k <= kBackgroundSteps; ++k) {
      const float offset = static_cast<float>(k) * kBackgroundReachPx / kBackgroundSteps;
      sum += bump(field_.distance(s.pixel + offset * s.normal, s.bin), s.inverse_kernel);
    }
    s.background = std::max(kMinBackground, sum / (2 * kBackgroundSteps + 1));
  }
}

double EdgeLikelihood::log_ratio(const Vector6d& delta) const {
  const Eigen::Matrix<float, 6, 1> d = delta.cast<float>();
  float sum = 0.0f;
  for (const LinearSample& s : samples_) {
    const float value = bump(field_.distance(s.pixel + s.jacobian * d, s.bin), s.inverse_kernel);
    sum += s.weight * std::log(1.0f - kInlierShare + kInlierShare * value / s.background);
  }
  return sum;
}

double EdgeLikelihood::log_ratio_fitted() const {
  std::vector<SampleLikelihood> samples;
  for (const LinearSample& s : samples_) {
    samples.push_back({s.kind, s.weight, bump(field_.distance(s.pixel, s.bin), s.inverse_kernel) / s.background});
  }
  return fitted_log_ratio(samples);
}

SampleLikelihood sample_likelihood(MapEdgeKind kind, int edge_samples, double width_px,
                                   const std::function<double(double offset_px)>& distance) {
  const float inverse_width = 1.0f / static_cast<float>(width_px);
  float sum = 0.0f;
  for (int k = -kBackgroundSteps; k <= kBackgroundSteps; ++k) {
    const float offset = static_cast<float>(k) * kBackgroundReachPx / kBackgroundSteps;
    sum += bump(static_cast<float>(distance(offset)), inverse_width);
  }
  const float background = std::max(kMinBackground, sum / (2 * kBackgroundSteps + 1));
  return {kind, std::min(1.0f, kIndependentSamples / static_cast<float>(edge_samples)),
          bump(static_cast<float>(distance(0.0)), inverse_width) / background};
}

double fitted_log_ratio(const std::vector<SampleLikelihood>& samples) {
  double sum = 0.0;
  for (const MapEdgeKind kind :
       {MapEdgeKind::kCrease, MapEdgeKind::kBoundary, MapEdgeKind::kIntensity, MapEdgeKind::kSilhouette}) {
    double best = 0.0;  // at share 0
    for (const float share : {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f, 0.9f}) {
      double of_kind = 0.0;
      for (const SampleLikelihood& s : samples) {
        if (s.kind == kind) of_kind += static_cast<double>(s.weight * std::log(1.0f - share + share * s.ratio));
      }
      best = std::max(best, of_kind);
    }
    sum += best;
  }
  return sum;
}

}  // namespace cpplus
