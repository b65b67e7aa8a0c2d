#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/cloud/point_map.h"
#include "cpplus/core/progress.h"
#include "cpplus/features/blur.h"
#include "cpplus/features/image_edges.h"
#include "cpplus/features/intensity_matching.h"
#include "cpplus/features/map_edges.h"
#include "cpplus/features/patch_matching.h"
#include "cpplus/features/plane_segmentation.h"
#include "cpplus/refine/joint_solver.h"
#include "cpplus/refine/joint_verdict.h"
#include "cpplus/refine/nid_pose.h"
#include "cpplus/refine/refine_pose.h"
#include "cpplus/report/refine_report.h"
#include "cpplus/visibility/plane_buffer_renderer.h"
#include "cpplus/visibility/silhouettes.h"

namespace cpplus {

/// What the baseline of line segments (pipeline/refine_baselines.h) has in place of the options of `refine`, since
/// it must come home without a search.
struct LineOptions {
  /// Rounds of matching and minimising. [1, inf)
  int max_iterations = 10;
  /// Samples look for an image edge this far in the first round, pixels. (0, inf)
  double first_radius_px = 20.0;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("max_iterations", max_iterations, "Rounds of matching and minimising.");
    visitor("first_radius_px", first_radius_px, "Samples look for an image edge this far in the first round, pixels.");
  }
};

/// Options of every stage from a map and an image to a refined pose.
struct RefineImagesOptions {
  /// The map is one room that is seen whole: no test of what hides what (Cui & Schwertfeger 2022, end of section III).
  bool local = false;
  VoxelMapOptions voxel_map;
  PlaneSegmentationOptions planes;
  MapEdgeOptions map_edges;
  PlaneBufferOptions visibility;
  SilhouetteOptions silhouettes;
  EdgeSampleOptions samples;
  BlurOptions blur;
  ImageEdgeOptions image_edges;
  RefinePoseOptions refine;
  PatchMatchingOptions patches;
  IntensityMatchingOptions intensities;
  JointOptions joint_solve;
  // Of the baselines alone (pipeline/refine_baselines.h).
  LineOptions lines;
  NidOptions nid;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("local", local, "The map is one room that is seen whole: skip the test of what hides what.");
    visitor.group("voxel_map", voxel_map);
    visitor.group("planes", planes);
    visitor.group("map_edges", map_edges);
    visitor.group("visibility", visibility);
    visitor.group("silhouettes", silhouettes);
    visitor.group("samples", samples);
    visitor.group("blur", blur);
    visitor.group("image_edges", image_edges);
    visitor.group("refine", refine);
    visitor.group("patches", patches);
    visitor.group("intensities", intensities);
    visitor.group("joint_solve", joint_solve);
    visitor.group("lines", lines);
    visitor.group("nid", nid);
  }
};

/// What refinement needs of a map, computed once.
struct MapFeatures {
  VoxelMap map;
  PlaneSegmentation planes;
  PlaneSurface surface;
  std::vector<MapEdge> edges;
  std::vector<float> leaf_spacing;  // of the points, metres (visibility/point_spacing.h)
  std::vector<float> intensities;   // in the order of the map (pipeline/grouped_features.h); empty: none are at hand
};

/// Finds them; advances the progress by kMapSteps. `noise_m`: the map's range noise where it is known (segment_planes).
MapFeatures extract_map_features(const PointMap& points, const RefineImagesOptions& options, Progress* progress,
                                 std::optional<double> noise_m = std::nullopt);
inline constexpr size_t kMapSteps = 4;

/// How far from the coarse pose of an image a map must reach for the same result as with all of it, metres: as far as
/// any stage looks, and a margin for a better pose and for planes and edges, which are cut where the map ends.
double map_reach_m(const RefineImagesOptions& options);

/// The map's edges and the silhouettes of one view, and the samples that the camera should see.
struct EdgesInView {
  std::vector<MapEdge> edges;
  std::vector<EdgeSample> samples;
};

EdgesInView find_edges_in_view(const MapFeatures& features, const Camera& camera, const Rigid3& camera_from_map,
                               const RefineImagesOptions& options);

/// How many edges the samples lie on.
size_t count_edges(const std::vector<EdgeSample>& samples);

/// The report of an image that keeps its coarse pose.
ImageReport unrefined_report(const std::string& name, const Rigid3& coarse_camera_from_map);

/// Decodes an image and notes how sharp it is. Nothing, with status and reason in the report, for an image that is
/// unreadable (`decode` throws Error) or blurred, or that sees no part of the map from the report's pose.
std::optional<GrayImage> open_image(const MapFeatures& features, const Camera& camera,
                                    const std::function<GrayImage()>& decode, const RefineImagesOptions& options,
                                    ImageReport* report);

/// One image against the map. `decode` yields the grey image or throws Error, which becomes the status `unreadable`.
/// `guess` is where the pose is looked for, the coarse pose what the result must beat.
ImageReport refine_image(const MapFeatures& features, const std::string& name, const Camera& camera,
                         const Rigid3& coarse_camera_from_map, const PoseGuess& guess,
                         const std::function<GrayImage()>& decode, const RefineImagesOptions& options);

/// What the joint solve needs of one image, seen from a pose that is nearly right.
struct JointView {
  EdgeEvidence edges;
  PatchView patches;
  std::vector<Eigen::Vector3d> surface_in_map;  // points of the map that the image sees, evenly over it
};

JointView prepare_joint_view(const MapFeatures& features, const Camera& camera, const Rigid3& camera_from_map,
                             const GrayImage& image, const RefineImagesOptions& options);

/// Patches of one image that show the LiDAR intensities of the map, looked for from a pose that is nearly right
/// (features/intensity_matching.h). None in a map without intensities, or where nothing is taken to hide (`local`).
std::vector<IntensityMatch> find_intensities_in_view(const MapFeatures& features, const ExpectedView& view,
                                                     const GrayImage& image, const RefineImagesOptions& options);

}  // namespace cpplus
