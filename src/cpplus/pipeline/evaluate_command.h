#pragma once

#include <string>

#include "cpplus/evaluate/model_comparison.h"

namespace cpplus {

struct EvaluateOptions {
  /// COLMAP model folder to be judged.
  std::string estimate;
  /// COLMAP model folder that it is compared with.
  std::string reference;
  /// Point cloud whose points, as far as the reference poses see them, give the reprojection shift; "" = none.
  std::string map;
  /// Folder of exact ranges, one STEM.npz an image, which take the place of the map; "" = none.
  std::string depth;
  /// COLMAP model folder with the poses that `depth` was made from; "" = the reference.
  std::string depth_poses;
  /// JSON file with checkerboard corners in the map and in the images; "" = none.
  std::string checkerboards;
  /// Text file with image names to leave out, one a line; "" = none.
  std::string exclude;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("estimate", estimate, "COLMAP model folder to be judged.");
    visitor("reference", reference, "COLMAP model folder that it is compared with.");
    visitor("map", map, "Point cloud whose visible points give the reprojection shift; empty = none.");
    visitor("depth", depth, "Folder of exact ranges (one STEM.npz an image) to use instead of the map; empty = none.");
    visitor("depth_poses", depth_poses, "COLMAP model folder that the ranges were made from; empty = the reference.");
    visitor("checkerboards", checkerboards, "JSON file with checkerboard corners; empty = none.");
    visitor("exclude", exclude, "Text file with image names to leave out, one a line; empty = none.");
  }
};

/// Reads what the options name and compares the two models. Surface points of an image come from its range file, else
/// from the map; with neither it has no reprojection shift. Throws Error naming the file for unreadable input, and
/// where the models have no image in common.
ModelComparison evaluate_models(const EvaluateOptions& options);

/// One JSON object: `images` (a list), `summary`, `absolute` (ATE), `relative` (RPE), `only_in_estimate`,
/// `only_in_reference`. A figure that does not exist is null.
std::string comparison_json(const ModelComparison& comparison);

/// The same to be read by a person: a line an image, then the summary.
std::string comparison_table(const ModelComparison& comparison);

}  // namespace cpplus
