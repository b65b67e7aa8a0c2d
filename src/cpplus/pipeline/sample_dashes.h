#pragma once

#include <vector>

#include "cpplus/refine/edge_samples.h"
#include "cpplus/report/overlay.h"

namespace cpplus {

/// The samples of the map's edges to be drawn over an image: one dash a sample, as long as the samples are apart in the
/// image of that camera.
std::vector<OverlaySegment> sample_dashes(const std::vector<EdgeSample>& samples, const Camera& camera,
                                          const Rigid3& camera_from_map, double spacing_px);

}  // namespace cpplus
