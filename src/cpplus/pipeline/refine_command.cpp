#include "cpplus/pipeline/refine_command.h"

#include <fmt/format.h>

#include <utility>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/pipeline/image_folder.h"
#include "cpplus/report/overlay.h"

namespace cpplus {
namespace {

GrayImage decode_for(const std::string& path, const Camera& camera) {
  GrayImage image = read_gray_image(path);
  if (image.width != camera.width() || image.height != camera.height()) {
    throw Error(fmt::format("{}: the image is {}x{}, its camera {}x{}", path, image.width, image.height, camera.width(),
                            camera.height()));
  }
  return image;
}

// One dash a sample, as long as the samples are apart.
std::vector<OverlaySegment> dashes(const std::vector<EdgeSample>& samples, const Camera& camera,
                                   const Rigid3& camera_from_map, double spacing_px) {
  std::vector<OverlaySegment> segments;
  const Eigen::Vector3d center = camera_center(camera_from_map);
  for (const EdgeSample& sample : samples) {
    const double half_m = 0.5 * spacing_px * (sample.x_in_map - center).norm() / camera.pixels_per_radian();
    segments.push_back(
        {sample.x_in_map - half_m * sample.direction_in_map, sample.x_in_map + half_m * sample.direction_in_map});
  }
  return segments;
}

void write_overlay(const RefineCommandOptions& options, const Camera& camera, const Rigid3& coarse,
                   const RefinedImage& refined) {
  if (options.debug_images.empty() || refined.samples.empty()) return;
  const ColorImage image = read_color_image(image_path(options.images, refined.report.name));
  const std::vector<OverlaySegment> segments =
      dashes(refined.samples, camera, coarse, options.stages.samples.spacing_px);
  write_png(image_path(options.debug_images, refined.report.name + ".png"),
            before_after_overlay(image, segments, camera, coarse, refined.report.camera_from_map, "before",
                                 "after: " + status_name(refined.report.status)));
}

RefineSummary summarise(const std::vector<ImageReport>& reports) {
  RefineSummary summary;
  summary.num_images = reports.size();
  for (const ImageReport& report : reports) {
    summary.num_refined += report.status == ImageStatus::kRefined;
    summary.num_kept_coarse += report.status == ImageStatus::kKeptCoarse;
    summary.num_blurred += report.status == ImageStatus::kBlurred;
    summary.num_outside_map += report.status == ImageStatus::kOutsideMap;
    summary.num_unreadable += report.status == ImageStatus::kUnreadable;
  }
  return summary;
}

SparseModel refined_model(const SparseModel& coarse, const std::vector<ImageReport>& reports, bool only_refined) {
  SparseModel model;
  model.cameras = coarse.cameras;
  for (size_t i = 0; i < coarse.images.size(); ++i) {
    if (only_refined && reports[i].status != ImageStatus::kRefined) continue;
    model.images.push_back(coarse.images[i]);
    model.images.back().camera_from_map = reports[i].camera_from_map;
  }
  return model;
}

std::vector<ImageReport> refine_all(const MapFeatures& features, const SparseModel& model,
                                    const RefineCommandOptions& options) {
  std::vector<ImageReport> reports(model.images.size());
  Progress progress("refine", model.images.size());
  parallel_for_each(model.images.size(), [&](size_t i) {
    const PosedImage& image = model.images[i];
    const Camera& camera = model.cameras.at(image.camera_id);
    const std::string path = image_path(options.images, image.name);
    const RefinedImage refined = refine_image(
        features, image.name, camera, image.camera_from_map, [&] { return decode_for(path, camera); }, options.stages);
    write_overlay(options, camera, image.camera_from_map, refined);
    reports[i] = refined.report;
    progress.advance();
  });
  return reports;
}

}  // namespace

void RefineCommandOptions::validate() const {
  for (const auto& [name, value] :
       {std::pair<const char*, const std::string&>{"map", map}, {"images", images}, {"poses", poses}, {"out", out}}) {
    if (value.empty()) throw UsageError(fmt::format("option {} must be given", name));
  }
  stages.validate();
}

RefineSummary refine_command(const RefineCommandOptions& options) {
  options.validate();
  const SparseModel model = read_sparse_model(options.poses);
  const ImageFolder folder = find_images(options.images, model);
  warn_of_unmatched(options.images, model, folder);
  MapReport map_report;
  map_report.path = options.map;
  ReadCounts counts;
  const PointCloud cloud = read_point_cloud(options.map, &counts);
  const MapFeatures features = extract_map_features(cloud, options.stages);
  map_report.num_points = features.map.num_points();
  map_report.num_dropped_points = counts.dropped_non_finite;
  map_report.num_planes = features.planes.planes.size();
  map_report.num_edges = features.edges.size();
  map_report.noise_m = features.planes.noise_m;

  const std::vector<ImageReport> reports = refine_all(features, model, options);
  const RefineSummary summary = summarise(reports);
  if (summary.num_unreadable == summary.num_images) {
    throw Error(fmt::format("{}: none of the model's images can be read", options.images));
  }
  RefineCommandOptions listed = options;
  write_sparse_model_text(options.out + "/sparse", refined_model(model, reports, options.only_refined));
  write_text_file(options.out + "/report.json", refine_report_json(map_report, reports, list_options(listed)));
  return summary;
}

}  // namespace cpplus
