#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cpplus/pipeline/refine_images.h"

namespace cpplus {

/// Simpler methods in the same program, for comparison (docs/baselines.md). Each has the signature of refine_image()
/// as far as it needs it, refines one image alone and leaves the figures that it does not have at 0.

/// Line segments in the manner of Yu et al. 2020: the edges of the whole map within reach, of whatever kind and whether
/// hidden or not, matched to the nearest image edges of their direction; least squares, no search, no outlines. Accepts
/// when its own residual (RMS of all samples) falls.
ImageReport refine_image_by_lines(const MapFeatures& features, const std::string& name, const Camera& camera,
                                  const Rigid3& coarse_camera_from_map, const std::function<GrayImage()>& decode,
                                  const RefineImagesOptions& options);

/// Normalised information distance in the manner of Koide et al. 2023 (refine/nid_pose.h). `intensities`: of the
/// map's points, equalised, in the order of the map; empty: the image keeps its coarse pose and says so.
ImageReport refine_image_by_nid(const MapFeatures& features, const std::vector<float>& intensities,
                                const std::string& name, const Camera& camera, const Rigid3& coarse_camera_from_map,
                                const std::function<GrayImage()>& decode, const RefineImagesOptions& options);

/// The coarse pose as it is, whatever the image holds.
ImageReport keep_coarse_pose(const std::string& name, const Rigid3& coarse_camera_from_map);

}  // namespace cpplus
