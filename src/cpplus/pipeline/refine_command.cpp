#include "cpplus/pipeline/refine_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/stamps_io.h"
#include "cpplus/io/trajectory_io.h"
#include "cpplus/pipeline/camera_velocity.h"
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

// Refines images of a model, all of them or some once more from a better guess.
class ModelRefiner {
 public:
  ModelRefiner(const MapFeatures& features, const SparseModel& model, const RefineCommandOptions& options,
               const std::map<std::string, double>& stamps, const Trajectory& trajectory)
      : features_(features),
        model_(model),
        options_(options),
        stamps_(stamps),
        trajectory_(trajectory),
        reports_(model.images.size()) {}

  std::vector<ImageReport> run() {
    std::vector<size_t> all(model_.images.size());
    std::iota(all.begin(), all.end(), size_t{0});
    std::vector<PoseGuess> guesses;
    for (const PosedImage& image : model_.images) {
      guesses.push_back({image.camera_from_map, options_.stages.refine.prior.sigmas()});
    }
    refine("refine", all, guesses);
    if (options_.joint) refine("refine doubtful", find_doubtful(&guesses), guesses);
    return reports_;
  }

  /// What the coarse poses of each camera have wrong in common; needs stamps.
  std::map<uint32_t, SharedErrors> shared_errors() const {
    std::map<uint32_t, SharedErrors> shared;
    if (stamps_.empty() || !options_.joint) return shared;
    for (const auto& [camera, sequence] : sequences()) {
      const Trajectory way = trajectory_.empty() ? coarse_trajectory(sequence) : trajectory_;
      std::vector<std::optional<Vector6d>> velocities;
      for (const auto& [time, i] : sequence) {
        velocities.push_back(camera_velocity(way, time, model_.images[i].camera_from_map));
      }
      const auto errors = estimate_shared_errors(corrections_of(sequence), velocities,
                                                 options_.stages.refine.prior.sigmas(), options_.stages.sequence);
      if (errors) shared[camera] = *errors;
    }
    return shared;
  }

 private:
  void refine(const std::string& label, const std::vector<size_t>& images, const std::vector<PoseGuess>& guesses) {
    Progress progress(label, images.size());
    parallel_for_each(images.size(), [&](size_t k) {
      const size_t i = images[k];
      const PosedImage& image = model_.images[i];
      const Camera& camera = model_.cameras.at(image.camera_id);
      const std::string path = image_path(options_.images, image.name);
      const RefinedImage refined = refine_image(
          features_, image.name, camera, image.camera_from_map, guesses[i], [&] { return decode_for(path, camera); },
          options_.stages);
      write_overlay(options_, camera, image.camera_from_map, refined);
      reports_[i] = refined.report;
      progress.advance();
    });
  }

  using ImageSequence = std::vector<std::pair<double, size_t>>;  // time, index of the image

  // Each camera of a rig has errors of its own, so each makes a sequence of its own.
  std::map<uint32_t, ImageSequence> sequences() const {
    std::map<uint32_t, ImageSequence> sequences;
    for (size_t i = 0; i < model_.images.size(); ++i) {
      const auto stamp = stamps_.find(model_.images[i].name);
      if (!stamps_.empty() && stamp == stamps_.end()) continue;
      sequences[model_.images[i].camera_id].emplace_back(stamps_.empty() ? static_cast<double>(i) : stamp->second, i);
    }
    for (auto& [camera, sequence] : sequences) std::sort(sequence.begin(), sequence.end());
    return sequences;
  }

  std::vector<size_t> find_doubtful(std::vector<PoseGuess>* guesses) const {
    std::vector<size_t> doubtful;
    for (const auto& [camera, sequence] : sequences()) find_doubtful_in(sequence, guesses, &doubtful);
    std::sort(doubtful.begin(), doubtful.end());
    return doubtful;
  }

  Trajectory coarse_trajectory(const ImageSequence& sequence) const {
    Trajectory trajectory;
    for (const auto& [time, i] : sequence) {
      if (!trajectory.empty() && time <= trajectory.back().stamp_s) continue;
      trajectory.push_back({time, inverse(model_.images[i].camera_from_map)});
    }
    return trajectory;
  }

  std::vector<PoseCorrection> corrections_of(const ImageSequence& sequence) const {
    std::vector<PoseCorrection> corrections;
    for (const auto& [time, i] : sequence) {
      const RefinePoseResult& r = reports_[i].refine;
      corrections.push_back({time, camera_difference(model_.images[i].camera_from_map, r.camera_from_map),
                             r.information, reports_[i].status == ImageStatus::kRefined});
    }
    return corrections;
  }

  void find_doubtful_in(const ImageSequence& sequence, std::vector<PoseGuess>* guesses,
                        std::vector<size_t>* doubtful) const {
    const std::vector<PoseCorrection> corrections = corrections_of(sequence);
    const std::vector<PosePrediction> predictions =
        predict_corrections(corrections, options_.stages.refine.prior.sigmas(), options_.stages.sequence);
    for (size_t k = 0; k < predictions.size(); ++k) {
      const size_t i = sequence[k].second;
      const bool contradicts = corrections[k].usable && predictions[k].consistency > kMaxConsistency;
      if (!contradicts && reports_[i].status != ImageStatus::kKeptCoarse) continue;
      (*guesses)[i] = {perturb_camera(model_.images[i].camera_from_map, predictions[k].mean), predictions[k].sigmas};
      doubtful->push_back(i);
    }
  }

  // Squared distance from its neighbours' prediction above which a pose is looked at again: 95 % of a chi-squared
  // variable with six degrees of freedom.
  static constexpr double kMaxConsistency = 12.6;

  const MapFeatures& features_;
  const SparseModel& model_;
  const RefineCommandOptions& options_;
  const std::map<std::string, double>& stamps_;
  const Trajectory& trajectory_;
  std::vector<ImageReport> reports_;
};

}  // namespace

void RefineCommandOptions::validate() const {
  for (const auto& [name, value] :
       {std::pair<const char*, const std::string&>{"map", map}, {"images", images}, {"poses", poses}, {"out", out}}) {
    if (value.empty()) throw UsageError(fmt::format("option {} must be given", name));
  }
  if (!trajectory.empty() && stamps.empty()) throw UsageError("option trajectory takes option stamps as well");
  stages.validate();
}

RefineSummary refine_command(const RefineCommandOptions& options) {
  options.validate();
  const SparseModel model = read_sparse_model(options.poses);
  const ImageFolder folder = find_images(options.images, model);
  warn_of_unmatched(options.images, model, folder);
  const std::map<std::string, double> stamps =
      options.stamps.empty() ? std::map<std::string, double>{} : read_stamps(options.stamps);
  const Trajectory trajectory = options.trajectory.empty() ? Trajectory{} : read_tum(options.trajectory);
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

  ModelRefiner refiner(features, model, options, stamps, trajectory);
  const std::vector<ImageReport> reports = refiner.run();
  const RefineSummary summary = summarise(reports);
  if (summary.num_unreadable == summary.num_images) {
    throw Error(fmt::format("{}: none of the model's images can be read", options.images));
  }
  RefineCommandOptions listed = options;
  write_sparse_model_text(options.out + "/sparse", refined_model(model, reports, options.only_refined));
  write_text_file(options.out + "/report.json",
                  refine_report_json(map_report, refiner.shared_errors(), reports, list_options(listed)));
  return summary;
}

}  // namespace cpplus
