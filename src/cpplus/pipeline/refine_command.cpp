#include "cpplus/pipeline/refine_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "cpplus/core/error.h"
#include "cpplus/core/interrupt.h"
#include "cpplus/core/log.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/map_io.h"
#include "cpplus/io/stamps_io.h"
#include "cpplus/io/trajectory_io.h"
#include "cpplus/pipeline/grouped_features.h"
#include "cpplus/pipeline/image_folder.h"
#include "cpplus/pipeline/image_sequences.h"
#include "cpplus/pipeline/joint_refinement.h"
#include "cpplus/pipeline/map_cache.h"
#include "cpplus/pipeline/refine_baselines.h"
#include "cpplus/pipeline/sample_dashes.h"

namespace cpplus {
namespace {

// Reason of the images that an interrupted run did not come to.
constexpr const char* kNotReached = "interrupted before it was looked at";

GrayImage decode_for(const std::string& path, const Camera& camera) {
  GrayImage image = read_gray_image(path);
  if (image.width != camera.width() || image.height != camera.height()) {
    throw Error(fmt::format("{}: the image is {}x{}, its camera {}x{}", path, image.width, image.height, camera.width(),
                            camera.height()));
  }
  return image;
}

void write_overlay(const RefineCommandOptions& options, const MapFeatures& features, const Camera& camera,
                   const Rigid3& coarse, const ImageReport& report) {
  const EdgesInView view = find_edges_in_view(features, camera, report.camera_from_map, options.stages);
  if (view.samples.empty()) return;
  const ColorImage image = read_color_image(image_path(options.images, report.name));
  const std::vector<OverlaySegment> segments =
      sample_dashes(view.samples, camera, report.camera_from_map, options.stages.samples.spacing_px);
  write_png(image_path(options.debug_images, report.name + ".png"),
            before_after_overlay(image, segments, camera, coarse, report.camera_from_map, "before",
                                 "after: " + status_name(report.status)));
}

RefineInputs absolute_inputs(const RefineCommandOptions& options) {
  const auto absolute = [](const std::string& path) {
    return std::filesystem::absolute(path).lexically_normal().string();
  };
  return {absolute(options.map), absolute(options.images), absolute(options.poses)};
}

KeptIntensities needed_intensities(const RefineCommandOptions& options) {
  if (options.method == "nid") return KeptIntensities::kEqualised;
  const bool are_matched = options.method == "cp_plus" && options.joint && options.stages.intensities.enabled;
  return are_matched ? KeptIntensities::kOfMap : KeptIntensities::kNone;
}

GroupedFeatures find_features(const RefineCommandOptions& options, const SparseModel& model, MapReport* report) {
  const std::string path = cached_map(options.map, options.cache, options.stages.voxel_map);
  PointMap points = read_map(path, options.stages.voxel_map);
  report->path = options.map;
  report->num_points = points.map.num_points();
  report->num_dropped_points = points.num_dropped_non_finite;
  std::optional<FeatureStore> store =
      open_feature_store(path, points, options.keep_features, options.stages, options.tiles);
  GroupedFeatures features(path, std::move(points), store ? &*store : nullptr, model, options.stages,
                           needed_intensities(options), static_cast<size_t>(options.max_group_points), options.out);
  if (store) {
    log_info(fmt::format("{}: planes and edges of {} tiles were found, those of {} were there", features_folder(path),
                         store->num_found(), store->num_read()));
  }
  report->num_planes = features.num_planes();
  report->num_edges = features.num_edges();
  report->noise_m = features.noise_m();
  return features;
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

SparseModel refined_model(const SparseModel& coarse, const std::map<uint32_t, Camera>& cameras,
                          const std::vector<ImageReport>& reports, bool only_refined) {
  SparseModel model;
  model.cameras = cameras;
  for (size_t i = 0; i < coarse.images.size(); ++i) {
    if (only_refined && reports[i].status != ImageStatus::kRefined) continue;
    model.images.push_back(coarse.images[i]);
    model.images.back().camera_from_map = reports[i].camera_from_map;
  }
  return model;
}

// Refines the images of a model: each on its own, the doubtful ones once more where the others expect them, then all
// together.
class ModelRefiner {
 public:
  ModelRefiner(GroupedFeatures* features, const SparseModel& model, const RefineCommandOptions& options,
               const std::map<std::string, double>& stamps, const Trajectory& trajectory)
      : features_(*features),
        model_(model),
        options_(options),
        reports_(model.images.size()),
        cameras_(model.cameras),
        input_{model, {}, {}, {}} {
    for (size_t i = 0; i < model.images.size(); ++i) {
      const PosedImage& image = model.images[i];
      guesses_.emplace_back(image.camera_from_map, options.stages.refine.prior.sigmas());
      reports_[i] = unrefined_report(image.name, image.camera_from_map);
      reports_[i].status = ImageStatus::kKeptCoarse;
      reports_[i].reason = kNotReached;
    }
    input_.sequences = image_sequences(model, stamps);
    input_.velocities_per_s = image_velocities(model, input_.sequences, !stamps.empty(), trajectory);
    input_.decode = [this](size_t i) { return decode(i); };
  }

  // After an interrupt what is done so far: the images that were looked at, each on its own.
  std::vector<ImageReport> run() {
    std::vector<size_t> all(model_.images.size());
    std::iota(all.begin(), all.end(), size_t{0});
    try {
      refine("refine", all);
      if (options_.joint && options_.method == "cp_plus") refine_together();
      if (!options_.debug_images.empty()) write_overlays();
    } catch (const Interrupted&) {
      interrupted_ = true;
      clear_interrupt();  // the results must be written
    }
    return reports_;
  }

  bool interrupted() const { return interrupted_; }

  const std::map<uint32_t, SharedErrors>& shared_errors() const { return shared_; }
  /// With the intrinsics found.
  const std::map<uint32_t, Camera>& cameras() const { return cameras_; }

 private:
  GrayImage decode(size_t i) const {
    const PosedImage& image = model_.images[i];
    return decode_for(image_path(options_.images, image.name), model_.cameras.at(image.camera_id));
  }

  void refine_together() {
    const std::vector<ImageReport> alone = reports_;
    try {
      look_again();
      solve_together();
    } catch (const Interrupted&) {
      reports_ = alone;
      throw;
    }
  }

  // Looks for doubtful images where the others expect them; what an image found before stays if its edges say so.
  void look_again() {
    const std::vector<ImageReport> before = reports_;
    refine("refine doubtful", find_doubtful());
    for (size_t i = 0; i < reports_.size(); ++i) {
      if (before[i].status != ImageStatus::kRefined) continue;
      const bool found = reports_[i].status == ImageStatus::kRefined;
      if (found && reports_[i].refine.held_out_after.log_ratio >= before[i].refine.held_out_after.log_ratio) continue;
      reports_[i] = before[i];
    }
  }

  void refine(const std::string& label, const std::vector<size_t>& images) {
    Progress progress(label, images.size());
    features_.for_each_group(images, [&](const MapFeatures& features, const std::vector<size_t>& some) {
      parallel_for_each(some.size(), [&](size_t k) {
        reports_[some[k]] = refine_one(features, some[k]);
        progress.advance();
      });
    });
  }

  ImageReport refine_one(const MapFeatures& features, size_t i) const {
    const PosedImage& image = model_.images[i];
    const Camera& camera = model_.cameras.at(image.camera_id);
    const auto decode_it = [this, i] { return decode(i); };
    if (options_.method == "none") return keep_coarse_pose(image.name, image.camera_from_map);
    if (options_.method == "lines") {
      return refine_image_by_lines(features, image.name, camera, image.camera_from_map, decode_it, options_.stages);
    }
    if (options_.method == "nid") {
      return refine_image_by_nid(features, features.intensities, image.name, camera, image.camera_from_map, decode_it,
                                 options_.stages);
    }
    return refine_image(features, image.name, camera, image.camera_from_map, guesses_[i], decode_it, options_.stages);
  }

  void write_overlays() {
    std::vector<size_t> drawn;
    for (size_t i = 0; i < reports_.size(); ++i) {
      const ImageStatus status = reports_[i].status;
      if (status == ImageStatus::kRefined || status == ImageStatus::kKeptCoarse) drawn.push_back(i);
    }
    features_.for_each_group(drawn, [&](const MapFeatures& features, const std::vector<size_t>& some) {
      parallel_for_each(some.size(), [&](size_t k) {
        const PosedImage& image = model_.images[some[k]];
        write_overlay(options_, features, cameras_.at(image.camera_id), image.camera_from_map, reports_[some[k]]);
      });
    });
  }

  // Images that found no pose, or another one than the others expect; sets their guesses to where these expect them.
  std::vector<size_t> find_doubtful() {
    const JointResult predicted = predict_poses(input_, reports_, options_.stages);
    std::vector<size_t> doubtful;
    for (const auto& [camera, sequence] : input_.sequences) {
      for (const auto& [time, i] : sequence) {
        const bool refined = reports_[i].status == ImageStatus::kRefined;
        if (!refined && reports_[i].status != ImageStatus::kKeptCoarse) continue;
        const PoseGuess& expected = predicted.poses[i].from_others;
        if (refined && expected.squared_distance(reports_[i].camera_from_map) < kMaxSquaredDistance) continue;
        guesses_[i] = expected;
        doubtful.push_back(i);
      }
    }
    std::sort(doubtful.begin(), doubtful.end());
    return doubtful;
  }

  void solve_together() {
    std::vector<Rigid3> start;
    for (size_t i = 0; i < model_.images.size(); ++i) {
      const bool refined = reports_[i].status == ImageStatus::kRefined;
      start.push_back(refined ? reports_[i].camera_from_map : guesses_[i].camera_from_map);
    }
    const JointResult result = refine_jointly(&features_, input_, start, options_.stages, &reports_);
    shared_ = result.shared;
    for (const auto& [id, camera] : result.cameras) cameras_[id] = camera;
  }

  // From where the others expect an image, above which it is looked at again: 95 % of a chi-squared variable with six
  // degrees of freedom.
  static constexpr double kMaxSquaredDistance = 12.6;

  GroupedFeatures& features_;
  const SparseModel& model_;
  const RefineCommandOptions& options_;
  std::vector<ImageReport> reports_;
  std::map<uint32_t, Camera> cameras_;
  JointRefinementInput input_;
  std::vector<PoseGuess> guesses_;
  std::map<uint32_t, SharedErrors> shared_;
  bool interrupted_ = false;
};

}  // namespace

void RefineCommandOptions::validate() const {
  for (const auto& [name, value] :
       {std::pair<const char*, const std::string&>{"map", map}, {"images", images}, {"poses", poses}, {"out", out}}) {
    if (value.empty()) throw UsageError(fmt::format("option {} must be given", name));
  }
  if (!trajectory.empty() && stamps.empty()) throw UsageError("option trajectory takes option stamps as well");
  if (method != "cp_plus" && method != "lines" && method != "nid" && method != "none") {
    throw UsageError(fmt::format("option method must be cp_plus, lines, nid or none, got '{}'", method));
  }
  check_option(max_group_points >= 1, "max_group_points", "[1, inf)", max_group_points);
  tiles.validate();
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
  GroupedFeatures features = find_features(options, model, &map_report);
  ModelRefiner refiner(&features, model, options, stamps, trajectory);
  const std::vector<ImageReport> reports = refiner.run();
  const RefineSummary summary = summarise(reports);
  if (summary.num_unreadable == summary.num_images) {
    throw Error(fmt::format("{}: none of the model's images can be read", options.images));
  }
  RefineCommandOptions listed = options;
  write_sparse_model_text(options.out + "/sparse",
                          refined_model(model, refiner.cameras(), reports, options.only_refined));
  write_text_file(
      options.out + "/report.json",
      refine_report_json(absolute_inputs(options), map_report, refiner.shared_errors(), reports, list_options(listed)));
  if (refiner.interrupted()) {
    const auto looked_at =
        std::count_if(reports.begin(), reports.end(), [](const ImageReport& r) { return r.reason != kNotReached; });
    throw Interrupted(fmt::format("interrupted: {} of {} images were looked at; {} holds their poses", looked_at,
                                  reports.size(), options.out));
  }
  return summary;
}

}  // namespace cpplus
