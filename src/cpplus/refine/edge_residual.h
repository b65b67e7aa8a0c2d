#pragma once

#include <vector>

namespace cpplus {

/// How well edge samples lie on image edges; distances are truncated at the first search radius.
struct EdgeResidual {
  int num_samples = 0;
  int num_matches = 0;  // samples with an image edge within the first search radius
  double median_px = 0.0;
  double rms_px = 0.0;
  double inlier_share = 0.0;  // of all samples: within the last search radius
  double log_ratio = 0.0;     // logarithm of the likelihood ratio to edges put at random (refine/edge_likelihood.h)
};

/// Sample count, median, RMS and inlier share of the samples' distances (pixels); the other figures stay 0.
EdgeResidual summarise_distances(std::vector<double> distances_px, double last_radius_px);

}  // namespace cpplus
