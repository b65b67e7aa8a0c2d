#include "cpplus/pipeline/refine_baselines.h"

#include <cmath>

#include "cpplus/cloud/select_roots.h"
#include "cpplus/core/stopwatch.h"
#include "cpplus/pipeline/nothing_hidden.h"
#include "cpplus/visibility/depth_buffer.h"

namespace cpplus {
namespace {

// All edges within reach, as if of one kind: then no sample is dropped for what hides it or for what lies beyond it.
EdgesInView whole_map_edges(const MapFeatures& features, const Camera& camera, const Rigid3& camera_from_map,
                            const RefineImagesOptions& options) {
  EdgesInView view;
  view.edges = features.edges;
  for (MapEdge& edge : view.edges) edge.kind = MapEdgeKind::kCrease;
  const PlaneBuffer planes = nothing_hidden(features.planes.planes, camera, camera_from_map);
  view.samples = sample_visible_edges(view.edges, camera, camera_from_map, planes, options.samples);
  return view;
}

void judge_by_residual(const RefinePoseOptions& options, ImageReport* report) {
  RefinePoseResult& result = report->refine;
  if (result.num_samples < options.min_samples) {
    report->reason = result.reason;
    return;
  }
  const bool falls = result.after.rms_px < result.before.rms_px;
  report->status = falls ? ImageStatus::kRefined : ImageStatus::kKeptCoarse;
  report->reason = falls ? "" : "the residual does not fall";
  if (falls) report->camera_from_map = result.candidate_camera_from_map;
}

// Every so manieth of the points that the camera sees from a pose; all in the order of the map.
std::vector<NidPoint> visible_points(const VoxelMap& map, const std::vector<float>& intensities, const Camera& camera,
                                     const Rigid3& camera_from_map, const NidOptions& options) {
  DepthBufferOptions buffer_options;
  buffer_options.max_distance_m = options.max_distance_m;
  const DepthBuffer buffer = render_depth_buffer(map, camera, camera_from_map, buffer_options);
  std::vector<NidPoint> seen;
  for (const uint32_t root : select_roots(map, camera, camera_from_map, options.max_distance_m)) {
    for (uint32_t i = map.points_begin(0, root); i < map.points_end(0, root); ++i) {
      const float intensity = intensities[i];
      const Eigen::Vector3d x_in_camera = camera_from_map * map.point(i);
      if (std::isnan(intensity) || x_in_camera.norm() > options.max_distance_m) continue;
      if (!buffer.is_visible(x_in_camera, options.occlusion_margin_m)) continue;
      seen.push_back({map.point(i), intensity});
    }
  }
  const size_t limit = static_cast<size_t>(options.max_points);
  if (seen.size() <= limit) return seen;
  std::vector<NidPoint> chosen;
  for (size_t k = 0; k < limit; ++k) chosen.push_back(seen[k * seen.size() / limit]);
  return chosen;
}

}  // namespace

ImageReport refine_image_by_lines(const MapFeatures& features, const std::string& name, const Camera& camera,
                                  const Rigid3& coarse_camera_from_map, const std::function<GrayImage()>& decode,
                                  const RefineImagesOptions& options) {
  ImageReport report = unrefined_report(name, coarse_camera_from_map);
  const auto image = open_image(features, camera, decode, options, &report);
  if (!image) return report;
  Stopwatch watch;
  const auto lap = [&](const char* stage) { report.milliseconds.emplace_back(stage, watch.lap()); };
  const EdgesInView view = whole_map_edges(features, camera, coarse_camera_from_map, options);
  report.num_map_edges = static_cast<int>(count_edges(view.samples));
  lap("map_edges");
  const ImageEdges image_edges = detect_image_edges(*image, options.image_edges);
  lap("image_edges");
  RefinePoseOptions refine = options.refine;
  refine.search.enabled = false;
  refine.max_iterations = options.lines.max_iterations;
  refine.first_radius_px = options.lines.first_radius_px;
  const PoseGuess guess(coarse_camera_from_map, refine.prior.sigmas());
  report.refine = refine_pose(camera, coarse_camera_from_map, guess, view.edges, view.samples, image_edges, refine);
  judge_by_residual(refine, &report);
  lap("refine");
  return report;
}

ImageReport refine_image_by_nid(const MapFeatures& features, const std::vector<float>& intensities,
                                const std::string& name, const Camera& camera, const Rigid3& coarse_camera_from_map,
                                const std::function<GrayImage()>& decode, const RefineImagesOptions& options) {
  ImageReport report = unrefined_report(name, coarse_camera_from_map);
  const auto image = open_image(features, camera, decode, options, &report);
  if (!image) return report;
  Stopwatch watch;
  if (intensities.empty()) {
    report.reason = "the map has no intensity";
    return report;
  }
  const auto visible = [&](const Rigid3& camera_from_map) {
    return visible_points(features.map, intensities, camera, camera_from_map, options.nid);
  };
  report.nid = refine_pose_nid(camera, coarse_camera_from_map, *image, visible, options.nid);
  report.status = report.nid->improved ? ImageStatus::kRefined : ImageStatus::kKeptCoarse;
  report.reason = report.nid->reason;
  report.camera_from_map = report.nid->camera_from_map;
  report.milliseconds.emplace_back("nid", watch.lap());
  return report;
}

ImageReport keep_coarse_pose(const std::string& name, const Rigid3& coarse_camera_from_map) {
  ImageReport report = unrefined_report(name, coarse_camera_from_map);
  report.reason = "no refinement was asked for";
  return report;
}

}  // namespace cpplus
