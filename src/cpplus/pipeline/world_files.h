#pragma once

#include <string>
#include <vector>

#include "cpplus/geometry/rigid3.h"
#include "cpplus/geometry/sparse_model.h"
#include "cpplus/simulate/simulate.h"

namespace cpplus {

/// The files of a simulated world that all scenes have (docs/simulator.md lists them), below its folder. Parent folders
/// are made. Throw Error where a file cannot be written.

/// The image itself and its true ranges.
void write_image(const SimulatedImage& image, const std::string& directory);

/// Stamps, and which images are blurred or show moving bodies; pixels and ranges are not looked at.
void write_image_lists(const SimulatedWorld& world, const std::string& directory);

/// The stated and the true trajectory; points are not looked at.
void write_scan_poses(const SimulatedWorld& world, const std::string& directory);

/// True, best and coarse camera poses, and the extrinsic.
void write_models(const SimulatedWorld& world, const std::string& directory);

/// The COLMAP model (one camera, no points) of the world's images with the given poses, in the order of the images.
SparseModel sparse_model_of(const SimulatedWorld& world, const std::vector<Rigid3>& camera_from_map);

}  // namespace cpplus
