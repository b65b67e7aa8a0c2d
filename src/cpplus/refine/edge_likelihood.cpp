#include "cpplus/refine/edge_likelihood.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "cpplus/core/fast_log.h"
#include "cpplus/core/vector_clones.h"

namespace cpplus {
namespace {

// Share of the map's edges that an image shows as edges.
constexpr float kInlierShare = 0.6f;
// Samples of one edge agree with each other: together they count as this many.
constexpr float kIndependentSamples = 4.0f;
constexpr int kBackgroundSteps = (EdgeLikelihood::kBackgroundPlaces - 1) / 2;  // on either side
constexpr float kBackgroundReachPx = 32.0f;
constexpr float kMinBackground = 0.03f;

// Offset of the k-th of the places across an edge that its background is told from, in pixels.
constexpr float background_offset(int k) { return static_cast<float>(k) * kBackgroundReachPx / kBackgroundSteps; }

float bump_rest(float distance, float inverse_kernel) {
  const float x = distance * inverse_kernel;
  return std::max(0.0f, 1.0f - x * x * (1.0f / 9.0f));
}

// Smooth bump: 1 at distance 0, 0 from three kernel widths on; the width of a Gaussian kernel without its exp().
float bump(float distance, float inverse_kernel) {
  const float rest = bump_rest(distance, inverse_kernel);
  const float squared = rest * rest;
  return squared * squared;
}

}  // namespace

EdgeLikelihood::EdgeLikelihood(const Camera& camera, const Rigid3& camera_from_map, const std::vector<MapEdge>& edges,
                               const std::vector<EdgeSample>& samples, const DirectionalDistanceField& field,
                               int max_samples)
    : field_(field) {
  const size_t most = static_cast<size_t>(std::max(1, max_samples));
  const size_t step = std::max<size_t>(1, (samples.size() + most - 1) / most);
  const SampleProjector projector(camera, camera_from_map);
  for (size_t i = 0; i < samples.size(); i += step) {
    const auto projected = projector.project(samples[i]);
    if (!projected) continue;
    add({&samples[i], *projected}, edges[samples[i].edge], static_cast<float>(step));
  }
  fill_up();
  look_around();
}

EdgeLikelihood::EdgeLikelihood(const std::vector<SampleInImage>& samples, const std::vector<MapEdge>& edges,
                               const DirectionalDistanceField& field)
    : field_(field) {
  for (const SampleInImage& s : samples) add(s, edges[s.sample->edge], 1.0f);
  fill_up();
  look_around();
}

void EdgeLikelihood::add(const SampleInImage& sample, const MapEdge& edge, float share) {
  const ProjectedSample& projected = sample.projected;
  x_.push_back(static_cast<float>(projected.pixel.x()));
  y_.push_back(static_cast<float>(projected.pixel.y()));
  for (Eigen::Index k = 0; k < 12; ++k) {
    jacobian_[static_cast<size_t>(k)].push_back(static_cast<float>(projected.d_pixel_d_delta(k / 6, k % 6)));
  }
  normal_x_.push_back(static_cast<float>(projected.normal.x()));
  normal_y_.push_back(static_cast<float>(projected.normal.y()));
  weight_.push_back(share * std::min(1.0f, kIndependentSamples / static_cast<float>(sample.sample->edge_samples)));
  const Eigen::RowVector3d across = projected.normal.transpose() * projected.d_pixel_d_point;
  map_variance_.push_back(static_cast<float>((across * edge.covariance * across.transpose()).value()));
  bin_.push_back(DirectionalDistanceField::bin_of(projected.normal));
  kind_.push_back(edge.kind);
}

void EdgeLikelihood::fill_up() {
  size_ = x_.size();
  const size_t filled = (size_ + kBlock - 1) / kBlock * kBlock;
  for (std::vector<float>* values : {&x_, &y_, &normal_x_, &normal_y_, &weight_}) values->resize(filled, 0.0f);
  map_variance_.resize(filled, 1.0f);
  for (std::vector<float>& values : jacobian_) values.resize(filled, 0.0f);
  bin_.resize(filled, 0);
  inverse_kernel_.resize(filled, 0.0f);
  inverse_background_.resize(filled, 0.0f);
}

CPPLUS_VECTOR_CLONES void EdgeLikelihood::look_around() {
  for (size_t k = 0; k < kBackgroundPlaces; ++k) {
    const float offset = background_offset(static_cast<int>(k) - kBackgroundSteps);
    distances_around_[k].resize(x_.size());
    for (size_t begin = 0; begin < x_.size(); begin += kBlock) {
      std::array<int32_t, kBlock> index;
      for (size_t i = 0; i < kBlock; ++i) {
        const size_t at = begin + i;
        index[i] = field_.index_of(x_[at] + offset * normal_x_[at], y_[at] + offset * normal_y_[at], bin_[at]);
      }
      for (size_t i = 0; i < kBlock; ++i) distances_around_[k][begin + i] = field_.distance_at(index[i]);
    }
  }
}

CPPLUS_VECTOR_CLONES void EdgeLikelihood::set_kernel(double kernel_px) {
  const float variance = static_cast<float>(kernel_px * kernel_px);
  for (size_t begin = 0; begin < x_.size(); begin += kBlock) {
    float* inverse_kernel = &inverse_kernel_[begin];
    for (size_t i = 0; i < kBlock; ++i) inverse_kernel[i] = 1.0f / std::sqrt(variance + map_variance_[begin + i]);
    std::array<float, kBlock> sums{};
    for (const std::vector<float>& distances : distances_around_) {
      for (size_t i = 0; i < kBlock; ++i) sums[i] += bump(distances[begin + i], inverse_kernel[i]);
    }
    for (size_t i = 0; i < kBlock; ++i) {
      inverse_background_[begin + i] = 1.0f / std::max(kMinBackground, sums[i] / kBackgroundPlaces);
    }
  }
}

double EdgeLikelihood::log_ratio(const Vector6d& delta) const { return log_ratios({&delta, 1}).front(); }

std::vector<double> EdgeLikelihood::log_ratios(std::span<const Vector6d> deltas) const {
  std::vector<Vector6f> steps;
  for (const Vector6d& delta : deltas) steps.push_back(delta.cast<float>());
  std::vector<BlockValues> sums(deltas.size(), BlockValues{});
  // All poses look at one block after the other: what the field holds around it then stays in the processor's cache.
  for (size_t begin = 0; begin < size_; begin += kBlock) add_block(begin, steps, &sums);
  std::vector<double> ratios;
  for (const BlockValues& of_pose : sums) {
    ratios.push_back(std::numbers::ln2 * static_cast<double>(std::accumulate(of_pose.begin(), of_pose.end(), 0.0f)));
  }
  return ratios;
}

CPPLUS_VECTOR_CLONES void EdgeLikelihood::add_block(size_t begin, const std::vector<Vector6f>& steps,
                                                    std::vector<BlockValues>* sums) const {
  for (size_t pose = 0; pose < steps.size(); ++pose) {
    const Vector6f& step = steps[pose];
    std::array<int32_t, kBlock> units;
    for (size_t i = 0; i < kBlock; ++i) {
      const size_t at = begin + i;
      float x = x_[at];
      float y = y_[at];
      for (size_t k = 0; k < 6; ++k) x += step(static_cast<Eigen::Index>(k)) * jacobian_[k][at];
      for (size_t k = 0; k < 6; ++k) y += step(static_cast<Eigen::Index>(k)) * jacobian_[k + 6][at];
      units[i] = field_.index_of(x, y, bin_[at]);
    }
    for (size_t i = 0; i < kBlock; ++i) units[i] = field_.units_at(units[i]);
    BlockValues& sum = (*sums)[pose];
    for (size_t i = 0; i < kBlock; ++i) {
      const float rest = bump_rest(field_.to_pixels(units[i]), inverse_kernel_[begin + i]);
      const float squared = rest * rest;
      const float ratio = squared * squared * inverse_background_[begin + i];
      sum[i] += weight_[begin + i] * fast_log2(1.0f - kInlierShare + kInlierShare * ratio);
    }
  }
}

double EdgeLikelihood::log_ratio_fitted() const {
  std::vector<SampleLikelihood> samples;
  for (size_t i = 0; i < size_; ++i) {
    const float distance = field_.distance_at(field_.index_of(x_[i], y_[i], bin_[i]));
    samples.push_back({kind_[i], weight_[i], bump(distance, inverse_kernel_[i]) * inverse_background_[i]});
  }
  return fitted_log_ratio(samples);
}

SampleLikelihood sample_likelihood(MapEdgeKind kind, int edge_samples, double width_px,
                                   const std::function<double(double offset_px)>& distance) {
  const float inverse_width = 1.0f / static_cast<float>(width_px);
  float sum = 0.0f;
  for (int k = -kBackgroundSteps; k <= kBackgroundSteps; ++k) {
    sum += bump(static_cast<float>(distance(background_offset(k))), inverse_width);
  }
  const float background = std::max(kMinBackground, sum / EdgeLikelihood::kBackgroundPlaces);
  return {kind, std::min(1.0f, kIndependentSamples / static_cast<float>(edge_samples)),
          bump(static_cast<float>(distance(0.0)), inverse_width) / background};
}

namespace {

constexpr size_t kNumKinds = static_cast<size_t>(MapEdgeKind::kSilhouette) + 1;
// Shares of edges that an image shows which are tried.
constexpr size_t kNumShares = 10;
constexpr std::array<float, kNumShares> kShares = {0.0f, 0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f, 0.9f};

CPPLUS_VECTOR_CLONES void add_log_ratios(const SampleLikelihood& sample, std::array<double, kNumShares>* sums) {
  for (size_t i = 0; i < kNumShares; ++i) {
    const float log2_ratio = fast_log2(1.0f - kShares[i] + kShares[i] * sample.ratio);
    (*sums)[i] += static_cast<double>(sample.weight * log2_ratio);
  }
}

}  // namespace

double fitted_log_ratio(const std::vector<SampleLikelihood>& samples) {
  std::array<std::array<double, kNumShares>, kNumKinds> sums{};
  for (const SampleLikelihood& sample : samples) add_log_ratios(sample, &sums[static_cast<size_t>(sample.kind)]);
  double sum = 0.0;
  for (const auto& of_kind : sums) sum += *std::max_element(of_kind.begin(), of_kind.end());
  return std::numbers::ln2 * sum;
}

}  // namespace cpplus
