#include "cpplus/pipeline/joint_refinement.h"

#include <algorithm>
#include <limits>
#include <map>

#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/core/stopwatch.h"
#include "cpplus/geometry/image_displacement.h"
#include "cpplus/refine/surface_match_residual.h"

namespace cpplus {
namespace {

// Images whose pixels are in memory at a time: two such blocks, consecutive in time. Images that are looked at as
// partners of an image, and how many of them at most become partners.
constexpr size_t kBlockImages = 48;
constexpr size_t kNearestImages = 12;
constexpr size_t kMaxPartners = 4;
// Least share of an image's patches that a partner should see.
constexpr double kMinOverlap = 0.15;
// What is looked at from elsewhere by more than half a patch's surface is another surface: while more than a share of
// the images turned out to be that far from where they were looked at, all are looked at once more. Not sooner: where
// little is known of a direction, each look goes a little along it.
constexpr int kMaxLooks = 3;
constexpr double kFarPx = 10.0;
constexpr double kMaxShareFar = 0.1;
// A patch fits when it lies this near to where the poses put it.
constexpr double kMaxPatchResidualPx = 1.5;

// NaN of nothing.
double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool takes_part(const ImageReport& report) {
  return report.status == ImageStatus::kRefined || report.status == ImageStatus::kKeptCoarse;
}

JointProblem make_problem(const JointRefinementInput& input) {
  JointProblem problem;
  problem.sequences = input.sequences;
  for (size_t i = 0; i < input.model.images.size(); ++i) {
    const PosedImage& image = input.model.images[i];
    JointImage joint;
    joint.camera = &input.model.cameras.at(image.camera_id);
    joint.camera_id = image.camera_id;
    joint.coarse_camera_from_map = image.camera_from_map;
    joint.camera_from_map = image.camera_from_map;
    joint.velocity_per_s = input.velocities_per_s[i];
    problem.images.push_back(joint);
  }
  return problem;
}

class JointRefiner {
 public:
  JointRefiner(GroupedFeatures* features, const JointRefinementInput& input, const std::vector<Rigid3>& start,
               const RefineImagesOptions& options, std::vector<ImageReport>* reports)
      : features_(*features),
        input_(input),
        start_(start),
        options_(options),
        cameras_(input.model.cameras),
        reports_(*reports),
        views_(input.model.images.size()) {
    std::vector<std::pair<double, size_t>> by_time;
    for (const auto& [camera, sequence] : input.sequences) {
      for (const auto& [time, i] : sequence) {
        if (takes_part(reports_[i])) by_time.emplace_back(time, i);
      }
    }
    std::sort(by_time.begin(), by_time.end());
    for (const auto& [time, i] : by_time) participants_.push_back(i);
  }

  JointResult run() {
    JointProblem problem = make_problem(input_);
    for (const size_t i : participants_) problem.images[i].edges = &views_[i].edges;
    std::vector<std::vector<SurfaceMatch>> matches;
    JointResult result;
    for (int look = 0; look < kMaxLooks; ++look) {
      matches = look_at_images();
      problem.matches.clear();
      for (const auto& some : matches) problem.matches.insert(problem.matches.end(), some.begin(), some.end());
      for (const size_t i : participants_) problem.images[i].camera_from_map = start_[i];
      result = solve(problem);
      if (!moved_far(result)) break;
      for (const size_t i : participants_) start_[i] = result.poses[i].camera_from_map;
    }
    // Intensities are looked for near where the camera is already known to be.
    const std::vector<std::vector<IntensityMatch>> intensities = match_intensities_at(result);
    if (std::any_of(intensities.begin(), intensities.end(), [](const auto& some) { return !some.empty(); })) {
      for (const size_t i : participants_) {
        problem.images[i].camera_from_map = result.poses[i].camera_from_map;
        problem.images[i].intensities = &intensities[i];
      }
      result = solve(problem);
    }
    judge(result, surface_supports(problem.matches, result));
    measure_surfaces(matches, result);
    measure_intensities(intensities, result);
    return result;
  }

 private:
  JointResult solve(const JointProblem& problem) {
    const RefinePoseOptions& refine = options_.refine;
    const JointEdgeOptions edges{refine.first_radius_px,
                                 refine.last_radius_px,
                                 refine.loss_scale,
                                 {refine.image_sigma_px, refine.edge_sigma_px},
                                 refine.search.last_kernel_px,
                                 refine.min_log_gain};
    JointResult result = solve_joint(problem, refine.prior.sigmas(), edges, options_.joint_solve);
    cameras_ = result.cameras;
    return result;
  }

  bool moved_far(const JointResult& result) const {
    const auto num_far = std::count_if(participants_.begin(), participants_.end(), [&](size_t i) {
      return mean_displacement_px(camera_of(i), views_[i].surface_in_map, start_[i], result.poses[i].camera_from_map) >
             kFarPx;
    });
    return static_cast<double>(num_far) > kMaxShareFar * static_cast<double>(participants_.size());
  }

  // With the intrinsics found, once they are.
  const Camera& camera_of(size_t i) const { return cameras_.at(input_.model.images[i].camera_id); }

  // Edges of all images, and the patches that each shares with others near to it in time: a list for each participant.
  // Blocks of images, of which two at a time are kept whole, bound the memory.
  std::vector<std::vector<SurfaceMatch>> look_at_images() {
    std::vector<std::vector<SurfaceMatch>> matches(participants_.size());
    Progress progress("look at images together", participants_.size());
    for (size_t begin = 0; begin < participants_.size(); begin += kBlockImages) {
      const size_t end = std::min(begin + kBlockImages, participants_.size());
      const size_t first_kept = begin < kBlockImages ? 0 : begin - kBlockImages;
      prepare_views({participants_.begin() + static_cast<std::ptrdiff_t>(begin),
                     participants_.begin() + static_cast<std::ptrdiff_t>(end)});
      parallel_for_each(end - begin, [&](size_t k) {
        matches[begin + k] = match_surfaces(participants_[begin + k], first_kept, end);
        progress.advance();
      });
      for (size_t k = first_kept; k < begin; ++k) views_[participants_[k]].patches = {};
    }
    for (const size_t i : participants_) views_[i].patches = {};
    return matches;
  }

  void prepare_views(const std::vector<size_t>& block) {
    features_.for_each_group(block, [&](const MapFeatures& features, const std::vector<size_t>& images) {
      parallel_for_each(images.size(), [&](size_t k) { prepare_view(features, images[k]); });
    });
  }

  void prepare_view(const MapFeatures& features, size_t i) {
    Stopwatch watch;
    views_[i] = prepare_joint_view(features, camera_of(i), start_[i], input_.decode(i), options_);
    reports_[i].milliseconds.emplace_back("joint_view", watch.lap());
  }

  // By image.
  std::vector<std::vector<IntensityMatch>> match_intensities_at(const JointResult& result) {
    std::vector<std::vector<IntensityMatch>> matches(views_.size());
    if (!options_.intensities.enabled) return matches;
    features_.for_each_group(participants_, [&](const MapFeatures& features, const std::vector<size_t>& images) {
      if (features.intensities.empty()) return;
      parallel_for_each(images.size(), [&](size_t k) {
        const size_t i = images[k];
        Stopwatch watch;
        const ExpectedView view{camera_of(i), result.poses[i].camera_from_map, result.poses[i].covariance};
        matches[i] = find_intensities_in_view(features, view, input_.decode(i), options_);
        reports_[i].milliseconds.emplace_back("match_intensities", watch.lap());
      });
    });
    return matches;
  }

  // Patches of image i in its partners among participants [begin, end).
  std::vector<SurfaceMatch> match_surfaces(size_t i, size_t begin, size_t end) {
    Stopwatch watch;
    std::vector<SurfaceMatch> matches;
    for (const size_t j : partners(i, begin, end)) {
      for (SurfaceMatch m : match_patches(views_[i].patches, views_[j].patches, options_.patches)) {
        m.image_a = static_cast<uint32_t>(i);
        m.image_b = static_cast<uint32_t>(j);
        matches.push_back(m);
      }
    }
    reports_[i].milliseconds.emplace_back("match_surfaces", watch.lap());
    return matches;
  }

  void measure_surfaces(const std::vector<std::vector<SurfaceMatch>>& matches, const JointResult& result) {
    for (size_t k = 0; k < participants_.size(); ++k) {
      std::vector<double> before, after;
      for (const SurfaceMatch& m : matches[k]) {
        const auto residual = [&](const ImagePose& a, const ImagePose& b, std::vector<double>* distances) {
          const auto r =
              surface_match_residual(m, camera_of(m.image_a), a, camera_of(m.image_b), b, result.range_scale);
          if (r) distances->push_back(r->residual.norm());
        };
        residual(input_.model.images[m.image_a].camera_from_map, input_.model.images[m.image_b].camera_from_map,
                 &before);
        residual(result.poses[m.image_a].image_pose(), result.poses[m.image_b].image_pose(), &after);
      }
      reports_[participants_[k]].surfaces = {static_cast<int>(matches[k].size()), median(before), median(after)};
    }
  }

  void measure_intensities(const std::vector<std::vector<IntensityMatch>>& matches, const JointResult& result) {
    for (const size_t i : participants_) {
      const Camera& camera = camera_of(i);
      const auto distances = [&](const ImagePose& pose) {
        std::vector<double> all;
        for (const IntensityMatch& m : matches[i]) {
          const auto pixel = camera.project(pose.at(row_fraction(m.pixel.y(), camera.height())) * m.x_in_map);
          if (pixel) all.push_back((*pixel - m.pixel).norm());
        }
        return all;
      };
      reports_[i].intensities = {static_cast<int>(matches[i].size()),
                                 median(distances(input_.model.images[i].camera_from_map)),
                                 median(distances(result.poses[i].image_pose()))};
    }
  }

  // Of the nearest images among participants [begin, end) those that see most of this one's patches.
  std::vector<size_t> partners(size_t i, size_t begin, size_t end) const {
    std::vector<std::pair<double, size_t>> near;
    const Eigen::Vector3d center = camera_center(start_[i]);
    for (size_t k = begin; k < end; ++k) {
      const size_t j = participants_[k];
      if (j != i) near.emplace_back((camera_center(start_[j]) - center).norm(), j);
    }
    const size_t count = std::min(kNearestImages, near.size());
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
    std::vector<std::pair<double, size_t>> by_overlap;
    for (size_t k = 0; k < count; ++k) {
      const double overlap = patch_overlap(views_[i].patches, views_[near[k].second].patches);
      if (overlap >= kMinOverlap) by_overlap.emplace_back(-overlap, near[k].second);
    }
    std::sort(by_overlap.begin(), by_overlap.end());
    std::vector<size_t> result;
    for (size_t k = 0; k < std::min(kMaxPartners, by_overlap.size()); ++k) result.push_back(by_overlap[k].second);
    return result;
  }

  // By image, as JointCandidate::surface_support.
  std::vector<int> surface_supports(const std::vector<SurfaceMatch>& matches, const JointResult& result) const {
    std::vector<int> supports(views_.size(), 0);
    for (const SurfaceMatch& m : matches) {
      const auto r =
          surface_match_residual(m, camera_of(m.image_a), result.poses[m.image_a].image_pose(), camera_of(m.image_b),
                                 result.poses[m.image_b].image_pose(), result.range_scale);
      const int vote = r && r->residual.norm() <= kMaxPatchResidualPx ? 1 : -1;
      supports[m.image_a] += vote;
      supports[m.image_b] += vote;
    }
    return supports;
  }

  // Does that hold for most images of a camera? holds(i)
  template <typename Holds>
  std::map<uint32_t, bool> cameras_with_most(const Holds& holds) const {
    std::map<uint32_t, int> surplus;
    for (const size_t i : participants_) surplus[input_.model.images[i].camera_id] += holds(i) ? 1 : -1;
    std::map<uint32_t, bool> most;
    for (const auto& [camera, count] : surplus) most[camera] = count > 0;
    return most;
  }

  void judge(const JointResult& result, const std::vector<int>& surface_supports) {
    const std::map<uint32_t, bool> proven = cameras_with_most([&](size_t i) { return result.poses[i].is_proven; });
    const auto candidate = [&](size_t i) {
      return JointCandidate{input_.model.images[i].camera_from_map,
                            result.poses[i],
                            &views_[i].edges,
                            views_[i].surface_in_map,
                            surface_supports[i],
                            proven.at(input_.model.images[i].camera_id)};
    };
    parallel_for_each(participants_.size(), [&](size_t k) {
      const size_t i = participants_[k];
      const RefinePoseResult alone = reports_[i].refine;
      RefinePoseResult together = judge_joint_pose(camera_of(i), candidate(i), alone.held_out_before, options_.refine);
      together.before = alone.before;
      together.iterations = alone.iterations;
      report(together, &reports_[i]);
    });
    const std::map<uint32_t, bool> believed =
        cameras_with_most([&](size_t i) { return reports_[i].status == ImageStatus::kRefined; });
    parallel_for_each(participants_.size(), [&](size_t k) {
      const size_t i = participants_[k];
      if (reports_[i].status == ImageStatus::kRefined || !believed.at(input_.model.images[i].camera_id)) return;
      RefinePoseResult together = reports_[i].refine;
      if (place_by_others(camera_of(i), candidate(i), options_.refine, &together)) report(together, &reports_[i]);
    });
  }

  static void report(const RefinePoseResult& together, ImageReport* report) {
    report->refine = together;
    report->camera_from_map = together.camera_from_map;
    report->status = together.status == RefineStatus::kRefined ? ImageStatus::kRefined : ImageStatus::kKeptCoarse;
    report->reason = together.reason;
  }

  GroupedFeatures& features_;
  const JointRefinementInput& input_;
  std::vector<Rigid3> start_;  // where images are looked at
  const RefineImagesOptions& options_;
  std::map<uint32_t, Camera> cameras_;
  std::vector<ImageReport>& reports_;
  std::vector<size_t> participants_;
  std::vector<JointView> views_;
};

}  // namespace

JointResult predict_poses(const JointRefinementInput& input, const std::vector<ImageReport>& reports,
                          const RefineImagesOptions& options) {
  JointProblem problem = make_problem(input);
  for (size_t i = 0; i < reports.size(); ++i) {
    if (reports[i].status != ImageStatus::kRefined) continue;
    problem.images[i].observed = PoseObservation{reports[i].camera_from_map, reports[i].refine.information};
  }
  JointOptions solve = options.joint_solve;
  solve.imaging.readout_sigma_s = 0.0;  // poses alone say nothing of either
  solve.imaging.intrinsics = false;
  return solve_joint(problem, options.refine.prior.sigmas(), {}, solve);
}

JointResult refine_jointly(GroupedFeatures* features, const JointRefinementInput& input,
                           const std::vector<Rigid3>& start_camera_from_map, const RefineImagesOptions& options,
                           std::vector<ImageReport>* reports) {
  return JointRefiner(features, input, start_camera_from_map, options, reports).run();
}

}  // namespace cpplus
