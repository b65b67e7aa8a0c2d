#pragma once

#include <functional>
#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/edge_samples.h"
#include "cpplus/refine/edgel_index.h"

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

/// How much better the edges of the map explain the image from a pose than edges put at random would: the sum over the
/// samples of log(1 - a + a k(d) / b), where d is the distance to the nearest image edge of the sample's direction, k a
/// kernel as wide as the edge is uncertain, b the mean of k around the sample, and a the share of edges that the image
/// shows. b is what keeps texture from looking like evidence. Poses are given as perturbations of the one about which
/// the projection is linearised.
class EdgeLikelihood {
 public:
  /// Looks at no more than max_samples of the samples, evenly. `field` must outlive this.
  EdgeLikelihood(const Camera& camera, const Rigid3& camera_from_map, const std::vector<MapEdge>& edges,
                 const std::vector<EdgeSample>& samples, const DirectionalDistanceField& field, int max_samples);

  /// Standard deviation of the kernel for an edge that is known exactly, pixels. To be set before log_ratio().
  void set_kernel(double kernel_px);

  /// Logarithm of the likelihood ratio at a perturbation (geometry/rigid3.h); 0 = as good as chance.
  double log_ratio(const Vector6d& delta) const;

  /// The same at the pose itself, with the share of edges that the image shows fitted to it for each kind of edge: a
  /// kind that this map has in vain (intensities that differ from one laser of the LiDAR to the next) then weighs
  /// nothing.
  double log_ratio_fitted() const;

  bool empty() const { return samples_.empty(); }

 private:
  struct LinearSample {
    Eigen::Vector2f pixel;
    Eigen::Matrix<float, 2, 6> jacobian;
    Eigen::Vector2f normal;
    float weight = 0.0f;
    float map_variance = 0.0f;  // of the map edge's position across itself, square pixels
    float inverse_kernel = 0.0f;
    float background = 1.0f;  // kernel value of a sample put here at random
    int bin = 0;
    MapEdgeKind kind = MapEdgeKind::kCrease;
  };

  const DirectionalDistanceField& field_;
  std::vector<LinearSample> samples_;
};

}  // namespace cpplus
