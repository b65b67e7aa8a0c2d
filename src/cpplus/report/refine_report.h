#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cpplus/core/option_list.h"
#include "cpplus/refine/joint_solver.h"
#include "cpplus/refine/nid_pose.h"
#include "cpplus/refine/refine_pose.h"

namespace cpplus {

enum class ImageStatus { kRefined, kKeptCoarse, kBlurred, kOutsideMap, kUnreadable };

/// "refined", "kept_coarse", "blurred", "outside_map", "unreadable".
std::string status_name(ImageStatus status);

/// How far patches of an image are from where they should be: of the map's surface, from where other images show them;
/// of LiDAR intensities, from where the image shows these.
struct PatchResidual {
  int num_matches = 0;
  double before_median_px = 0.0;  // by the coarse poses
  double after_median_px = 0.0;   // by the poses of the joint solve, accepted or not
};

struct ImageReport {
  std::string name;
  ImageStatus status = ImageStatus::kKeptCoarse;
  std::string reason;  // why it was not refined, one sentence; empty when refined
  Rigid3 camera_from_map;
  int num_map_edges = 0;    // that should be seen
  RefinePoseResult refine;  // figures; defaults where it was not reached
  PatchResidual surfaces;
  PatchResidual intensities;
  std::optional<NidResult> nid;  // of that baseline alone
  double sharpness = 0.0;
  std::vector<std::pair<std::string, double>> milliseconds;  // in order; a stage that was gone through twice has two
};

struct MapReport {
  std::string path;
  size_t num_points = 0;
  size_t num_dropped_points = 0;  // NaN or infinite
  size_t num_planes = 0;
  size_t num_edges = 0;
  double noise_m = 0.0;
};

/// Absolute paths of what was refined, so that other commands find it from report.json alone.
struct RefineInputs {
  std::string map;
  std::string images;
  std::string poses;
};

/// report.json. Numbers that do not exist are null.
/// `shared`: by camera id.
std::string refine_report_json(const RefineInputs& inputs, const MapReport& map,
                               const std::map<uint32_t, SharedErrors>& shared, const std::vector<ImageReport>& images,
                               const std::vector<OptionField>& options);

}  // namespace cpplus
