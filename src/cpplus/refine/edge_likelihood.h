#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/edge_samples.h"
#include "cpplus/refine/edgel_index.h"
#include "cpplus/refine/projected_sample.h"

namespace cpplus {

/// One sample's part in the likelihood ratio of EdgeLikelihood.
struct SampleLikelihood {
  MapEdgeKind kind = MapEdgeKind::kCrease;
  float weight = 1.0f;  // samples of one edge agree with each other: together they count as a few
  float ratio = 0.0f;   // kernel at the sample over the mean of the kernel around it
};

/// `distance(offset)` is the distance, in pixels, to the nearest image edge from a place `offset` pixels across the
/// edge from the sample; `width_px` is the kernel's standard deviation.
SampleLikelihood sample_likelihood(MapEdgeKind kind, int edge_samples, double width_px,
                                   const std::function<double(double offset_px)>& distance);

/// Sum of log(1 - a + a ratio) with the share a of edges that the image shows fitted for each kind of edge.
double fitted_log_ratio(const std::vector<SampleLikelihood>& samples);

/// An edge sample and where a pose sees it.
struct SampleInImage {
  const EdgeSample* sample = nullptr;
  ProjectedSample projected;
};

/// How much better the edges of the map explain the image from a pose than edges put at random would: the sum over the
/// samples of log(1 - a + a k(d) / b), where d is the distance to the nearest image edge of the sample's direction, k a
/// kernel as wide as the edge is uncertain, b the mean of k around the sample, and a the share of edges that the image
/// shows. b is what keeps texture from looking like evidence. Poses are given as perturbations of the one about which
/// the projection is linearised.
class EdgeLikelihood {
 public:
  /// Places across an edge, itself the middle one, that tell b.
  static constexpr int kBackgroundPlaces = 17;

  /// Looks at no more than max_samples of the samples, evenly. `field` must outlive this.
  EdgeLikelihood(const Camera& camera, const Rigid3& camera_from_map, const std::vector<MapEdge>& edges,
                 const std::vector<EdgeSample>& samples, const DirectionalDistanceField& field, int max_samples);
  /// Looks at all of them.
  EdgeLikelihood(const std::vector<SampleInImage>& samples, const std::vector<MapEdge>& edges,
                 const DirectionalDistanceField& field);

  /// Standard deviation of the kernel for an edge that is known exactly, pixels. To be set before log_ratio().
  void set_kernel(double kernel_px);

  /// Logarithm of the likelihood ratio at a perturbation (geometry/rigid3.h); 0 = as good as chance.
  double log_ratio(const Vector6d& delta) const;
  /// Those of many poses, in less time than one by one.
  std::vector<double> log_ratios(std::span<const Vector6d> deltas) const;

  /// The same at the pose itself, with the share of edges that the image shows fitted to it for each kind of edge: a
  /// kind that this map has in vain (intensities that differ from one laser of the LiDAR to the next) then weighs
  /// nothing.
  double log_ratio_fitted() const;

  bool empty() const { return size_ == 0; }

 private:
  // Samples are looked at in blocks of so many; the last block is filled up with samples of no weight.
  static constexpr size_t kBlock = 32;
  using BlockValues = std::array<float, kBlock>;
  using Vector6f = Eigen::Matrix<float, 6, 1>;

  // `share`: for how many samples this one stands.
  void add(const SampleInImage& sample, const MapEdge& edge, float share);
  void fill_up();
  void look_around();
  // Adds to the sums of each pose what the samples from `begin` on say.
  void add_block(size_t begin, const std::vector<Vector6f>& steps, std::vector<BlockValues>* sums) const;

  const DirectionalDistanceField& field_;
  size_t size_ = 0;
  // One element a sample.
  std::vector<float> x_, y_;                     // pixel
  std::array<std::vector<float>, 12> jacobian_;  // d x, then d y, by the perturbation
  std::vector<float> normal_x_, normal_y_;
  std::vector<float> weight_;
  std::vector<float> map_variance_;  // of the map edge's position across itself, square pixels
  std::vector<float> inverse_kernel_;
  std::vector<float> inverse_background_;  // of the kernel's value of a sample put here at random
  std::array<std::vector<float>, kBackgroundPlaces> distances_around_;  // to the nearest image edge, pixels
  std::vector<int32_t> bin_;
  std::vector<MapEdgeKind> kind_;
};

}  // namespace cpplus
