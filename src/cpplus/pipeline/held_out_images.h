#pragma once

#include <string>
#include <vector>

#include "cpplus/geometry/sparse_model.h"
#include "cpplus/pipeline/drawn_points.h"
#include "cpplus/report/colorize_report.h"

namespace cpplus {

/// Indices into the images of a model.
struct HeldOutSplit {
  std::vector<size_t> colored;
  std::vector<size_t> held_out;
};

/// Holds out the last of each `every` images, in their order; none for 0.
HeldOutSplit split_images(const std::vector<size_t>& images, int every);

struct HeldOutRendering {
  double max_distance_m = 50.0;  // surfaces farther than this hide nothing
  double point_size_m = 0.025;   // edge of the square that a point is drawn as
};

/// Renders the coloured cloud from the pose that `poses` has for each held-out image (by name), darkens the corners as
/// its camera does (result.vignetting), and compares it with the photo. Images that cannot be read, are of another size
/// than their camera, or without a pose are left out with a warning. `model` gives the cameras.
std::vector<HeldOutImage> compare_held_out(const std::string& image_folder, const SparseModel& model,
                                           const std::vector<size_t>& held_out, const SparseModel& poses,
                                           const ColoredCloud& cloud, const ColorizeResult& result,
                                           const HeldOutRendering& rendering);

}  // namespace cpplus
