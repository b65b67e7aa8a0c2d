#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/image_edge.h"
#include "cpplus/geometry/image_pose.h"
#include "cpplus/refine/edge_match.h"
#include "cpplus/refine/edge_samples.h"

namespace cpplus {

/// What an image says of its pose, in a form that can be kept for thousands of images at once (some 100 bytes a
/// sample): for each map edge sample the image edges of its direction that lie near its place, seen from a reference
/// pose that is some pixels off at most. The image itself is not needed any more.
class EdgeEvidence {
 public:
  EdgeEvidence() = default;

  /// Candidates are the edgels within radius_px along the normal of the projected sample whose own normal differs from
  /// it by at most max_angle_deg, one for each image edge that is crossed.
  EdgeEvidence(const Camera& camera, const ImagePose& pose, const std::vector<MapEdge>& edges,
               const std::vector<EdgeSample>& samples, const ImageEdges& image_edges, double radius_px,
               double max_angle_deg);

  /// Standard deviations of a match: one sample's own, and what all samples of an edge have in common, pixels.
  struct Noise {
    double image_sigma_px = 0.5;
    double edge_sigma_px = 0.6;
  };

  /// Indices of samples.
  using Selection = std::vector<uint32_t>;

  /// Matches each selected sample with its nearest candidate across the projected edge, within radius_px.
  std::vector<EdgeMatch> match(const Camera& camera, const ImagePose& pose, double radius_px, const Noise& noise,
                               const Selection& selection) const;

  /// Logarithm of the likelihood ratio of the selected samples to edges put at random, as
  /// EdgeLikelihood::log_ratio_fitted(), with a kernel of that standard deviation.
  double log_ratio(const Camera& camera, const ImagePose& pose, double kernel_px, const Selection& selection) const;

  /// Distances of the selected samples to their nearest candidates, at most radius_px, pixels.
  std::vector<double> distances(const Camera& camera, const ImagePose& pose, double radius_px,
                                const Selection& selection) const;

  size_t num_samples() const { return samples_.size(); }
  Selection all() const;
  /// Deals the samples into folds: whole edges with all their pieces, since samples of one edge fit together, in the
  /// order of their samples, so that every fold has long and short ones.
  std::vector<Selection> folds(int count) const;

 private:
  struct Sample {
    EdgeSample sample;
    Eigen::Matrix3f covariance;  // of the map edge's position, square metres
    float length_m = 0.0f;       // of the map edge
    MapEdgeKind kind = MapEdgeKind::kCrease;
    uint32_t group = 0;
    uint32_t candidates_begin = 0;
    uint32_t candidates_end = 0;
  };

  // Distance to the nearest candidate from a pixel that lies `offset_px` from the projected sample across the edge.
  double nearest(const Sample& s, const ProjectedSample& projected, double offset_px, double most_px) const;

  std::vector<Sample> samples_;
  std::vector<Eigen::Vector2f> candidates_;  // pixels of edgels
};

}  // namespace cpplus
