#include "cpplus/pipeline/refine_images.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "cpplus/cloud/select_roots.h"
#include "cpplus/core/error.h"
#include "cpplus/core/progress.h"
#include "cpplus/core/stopwatch.h"
#include "cpplus/geometry/tangent_box.h"
#include "cpplus/pipeline/nothing_hidden.h"
#include "cpplus/visibility/point_spacing.h"
#include "cpplus/visibility/points_on_planes.h"

namespace cpplus {
namespace {

// Points lie on the plane that is seen there within so many standard deviations of the map's noise.
constexpr double kOnPlaneNoises = 6.0;
// How far from their place as seen from a nearly right pose the image edges of a sample are kept.
constexpr double kCandidateRadiusPx = 40.0;
// Points of the seen surface along the longer side of the image.
constexpr int kSurfacePoints = 16;
// The map near an image reaches this much farther than what it looks at, metres: pieces of edges are 1.5 m long, planes
// are fitted to their whole extent.
constexpr double kReachMarginM = 8.0;

bool sees_map(const MapFeatures& features, const Camera& camera, const Rigid3& camera_from_map, double max_distance_m) {
  return !select_roots(features.map, camera, camera_from_map, max_distance_m).empty();
}

// What hides what as seen from a pose; in a local map nothing does.
PlaneBuffer hiding_planes(const MapFeatures& features, const Camera& camera, const Rigid3& camera_from_map,
                          const RefineImagesOptions& options) {
  if (!options.local) {
    return render_plane_buffer(features.map, features.planes, features.surface, camera, camera_from_map,
                               options.visibility);
  }
  return nothing_hidden(features.planes.planes, camera, camera_from_map);
}

std::vector<Eigen::Vector3d> seen_surface(const PlaneBuffer& planes) {
  std::vector<Eigen::Vector3d> points;
  const double step = static_cast<double>(std::max(planes.camera.width(), planes.camera.height())) / kSurfacePoints;
  const Rigid3 map_from_camera = inverse(planes.camera_from_map);
  for (double y = 0.5 * step; y < planes.camera.height(); y += step) {
    for (double x = 0.5 * step; x < planes.camera.width(); x += step) {
      const Eigen::Vector2d pixel(x, y);
      const int32_t id = planes.plane_at(pixel);
      if (id == PlaneBuffer::kNone) continue;
      const double range = planes.range_of((*planes.planes)[static_cast<size_t>(id)], pixel);
      if (range > 0) points.push_back(map_from_camera * Eigen::Vector3d(range * *planes.camera.unproject(pixel)));
    }
  }
  return points;
}

}  // namespace

size_t count_edges(const std::vector<EdgeSample>& samples) {
  std::set<uint32_t> edges;
  for (const EdgeSample& sample : samples) edges.insert(sample.edge);
  return edges.size();
}

void LineOptions::validate() const {
  check_option(max_iterations >= 1, "max_iterations", "[1, inf)", max_iterations);
  check_option(first_radius_px > 0, "first_radius_px", "(0, inf)", first_radius_px);
}

void RefineImagesOptions::validate() const {
  voxel_map.validate();
  planes.validate();
  map_edges.validate();
  visibility.validate();
  silhouettes.validate();
  samples.validate();
  blur.validate();
  image_edges.validate();
  refine.validate();
  patches.validate();
  intensities.validate();
  joint_solve.validate();
  lines.validate();
  nid.validate();
}

MapFeatures extract_map_features(const PointMap& points, const RefineImagesOptions& options, Progress* progress,
                                 std::optional<double> noise_m) {
  MapFeatures features;
  features.map = points.map;
  features.planes = segment_planes(features.map, options.planes, noise_m);
  progress->advance();
  features.surface = collect_plane_surface(features.map, features.planes, options.visibility);
  progress->advance();
  features.edges = find_map_edges(features.map, points.intensities, features.planes, options.map_edges);
  progress->advance();
  features.leaf_spacing = leaf_point_spacing(features.map);
  progress->advance();
  return features;
}

double map_reach_m(const RefineImagesOptions& options) {
  return kReachMarginM + std::max({options.visibility.max_distance_m, options.silhouettes.max_distance_m,
                                   options.samples.max_distance_m, options.nid.max_distance_m});
}

namespace {

// Adds those of which a part may lie in the image and within the distance: of a large map few.
void add_edges_near(const std::vector<MapEdge>& edges, const Camera& camera, const Rigid3& camera_from_map,
                    double distance_m, std::vector<MapEdge>* near) {
  const Eigen::Matrix3d rotation = camera_from_map.rotation.toRotationMatrix();
  const TangentBox box = tangent_box(camera);
  for (const MapEdge& edge : edges) {
    const Eigen::Vector3d center = rotation * (0.5 * (edge.start + edge.end)) + camera_from_map.translation;
    const double reach_m = 0.5 * edge.length();
    if (center.norm() > distance_m + reach_m) continue;
    if (!box.excludes(center.cast<float>(), static_cast<float>(reach_m))) near->push_back(edge);
  }
}

EdgesInView edges_in_view(const MapFeatures& features, const PlaneBuffer& planes,
                          const std::vector<MapEdge>& silhouettes, const RefineImagesOptions& options) {
  EdgesInView view;
  add_edges_near(features.edges, planes.camera, planes.camera_from_map, options.samples.max_distance_m, &view.edges);
  append_groups(silhouettes, first_free_group(view.edges), &view.edges);
  view.samples = sample_visible_edges(view.edges, planes.camera, planes.camera_from_map, planes, options.samples);
  return view;
}

EdgesInView edges_in_view(const MapFeatures& features, const PlaneBuffer& planes, const RefineImagesOptions& options) {
  return edges_in_view(features, planes,
                       find_silhouettes(features.map, features.leaf_spacing, planes, options.silhouettes), options);
}

}  // namespace

EdgesInView find_edges_in_view(const MapFeatures& features, const Camera& camera, const Rigid3& camera_from_map,
                               const RefineImagesOptions& options) {
  return edges_in_view(features, hiding_planes(features, camera, camera_from_map, options), options);
}

ImageReport unrefined_report(const std::string& name, const Rigid3& coarse_camera_from_map) {
  ImageReport report;
  report.name = name;
  report.camera_from_map = coarse_camera_from_map;
  report.refine.camera_from_map = coarse_camera_from_map;
  return report;
}

std::optional<GrayImage> open_image(const MapFeatures& features, const Camera& camera,
                                    const std::function<GrayImage()>& decode, const RefineImagesOptions& options,
                                    ImageReport* report) {
  const auto refuse = [&](ImageStatus status, const std::string& reason) {
    report->status = status;
    report->reason = reason;
    return std::nullopt;
  };
  Stopwatch watch;
  GrayImage image;
  try {
    image = decode();
  } catch (const Error& error) {
    return refuse(ImageStatus::kUnreadable, error.what());
  }
  report->milliseconds.emplace_back("decode", watch.lap());

  const BlurResult blur = measure_blur(image, options.blur);
  report->sharpness = blur.sharpness;
  report->milliseconds.emplace_back("blur", watch.lap());
  if (blur.blurred) return refuse(ImageStatus::kBlurred, "the image is blurred");
  if (!sees_map(features, camera, report->camera_from_map, options.samples.max_distance_m)) {
    return refuse(ImageStatus::kOutsideMap, "no part of the map is in view");
  }
  return image;
}

ImageReport refine_image(const MapFeatures& features, const std::string& name, const Camera& camera,
                         const Rigid3& coarse_camera_from_map, const PoseGuess& guess,
                         const std::function<GrayImage()>& decode, const RefineImagesOptions& options) {
  ImageReport report = unrefined_report(name, coarse_camera_from_map);
  const auto image = open_image(features, camera, decode, options, &report);
  if (!image) return report;
  Stopwatch watch;
  const auto lap = [&](const char* stage) { report.milliseconds.emplace_back(stage, watch.lap()); };
  const PlaneBuffer planes = hiding_planes(features, camera, guess.camera_from_map, options);
  lap("visibility");
  const EdgesInView view = edges_in_view(features, planes, options);
  report.num_map_edges = static_cast<int>(count_edges(view.samples));
  lap("map_edges");

  const ImageEdges image_edges = detect_image_edges(*image, options.image_edges);
  lap("image_edges");
  report.refine =
      refine_pose(camera, coarse_camera_from_map, guess, view.edges, view.samples, image_edges, options.refine);
  report.camera_from_map = report.refine.camera_from_map;
  lap("refine");
  const bool refined = report.refine.status == RefineStatus::kRefined;
  report.status = refined ? ImageStatus::kRefined : ImageStatus::kKeptCoarse;
  report.reason = report.refine.reason;
  return report;
}

JointView prepare_joint_view(const MapFeatures& features, const Camera& camera, const Rigid3& camera_from_map,
                             const GrayImage& image, const RefineImagesOptions& options) {
  const PlaneBuffer planes = hiding_planes(features, camera, camera_from_map, options);
  PointsInView points = points_in_view(features.map, features.leaf_spacing, planes, options.silhouettes.max_distance_m,
                                       options.silhouettes.cell_px);
  if (options.patches.enabled) add_points_by_cell(features.planes.noise_m, &points);
  EdgesInView seen =
      edges_in_view(features, planes, find_silhouettes(points, camera, camera_from_map, options.silhouettes), options);
  if (!options.local) drop_hidden_samples(points.raster, camera, camera_from_map, options.samples, &seen.samples);
  JointView view;
  view.edges =
      EdgeEvidence(camera, camera_from_map, seen.edges, seen.samples, detect_image_edges(image, options.image_edges),
                   kCandidateRadiusPx, options.refine.max_angle_deg);
  view.patches = prepare_patch_view(image, planes, points.raster, options.patches);
  view.surface_in_map = seen_surface(planes);
  return view;
}

std::vector<IntensityMatch> find_intensities_in_view(const MapFeatures& features, const ExpectedView& view,
                                                     const GrayImage& image, const RefineImagesOptions& options) {
  if (features.intensities.empty()) return {};
  const PlaneBuffer planes = hiding_planes(features, view.camera, view.camera_from_map, options);
  std::vector<IntensityPoint> points;
  for (const PointInView& seen :
       points_on_seen_planes(features.map, features.leaf_spacing, planes, options.visibility.max_distance_m,
                             kOnPlaneNoises * features.planes.noise_m)) {
    const float intensity = features.intensities[seen.index];
    if (std::isfinite(intensity)) points.push_back({seen.pixel, features.map.point(seen.index), intensity});
  }
  return match_intensities(points, image, view, options.intensities);
}

}  // namespace cpplus
