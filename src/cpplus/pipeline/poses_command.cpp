#include "cpplus/pipeline/poses_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/options.h"
#include "cpplus/geometry/rig.h"
#include "cpplus/geometry/scaled_camera.h"
#include "cpplus/geometry/sparse_model.h"
#include "cpplus/geometry/trajectory_spline.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/image_stamps.h"
#include "cpplus/io/pose_file.h"
#include "cpplus/io/rig_io.h"
#include "cpplus/pipeline/image_folder.h"
#include "cpplus/pipeline/upright_check.h"

namespace cpplus {
namespace {

std::optional<Eigen::Vector3d> up_axis(const std::string& name) {
  const double sign = name.starts_with("-") ? -1.0 : 1.0;
  const std::string letter = sign < 0.0 ? name.substr(1) : name;
  if (letter == "x") return sign * Eigen::Vector3d::UnitX();
  if (letter == "y") return sign * Eigen::Vector3d::UnitY();
  if (letter == "z") return sign * Eigen::Vector3d::UnitZ();
  return {};
}

std::string images_text(size_t count) { return fmt::format("{} image{}", count, count == 1 ? "" : "s"); }

Trajectory read_trajectory(const PosesCommandOptions& options) {
  const OrderedTrajectory ordered = order_by_stamp(read_pose_file(options.trajectory, options.times));
  const size_t num_poses = ordered.trajectory.size() + ordered.num_double;
  if (ordered.num_out_of_order > 0) {
    log_warning(
        fmt::format("{}: {} of {} poses with a stamp before that of the pose above, sorted in; the first is at {} s",
                    options.trajectory, ordered.num_out_of_order, num_poses, ordered.first_out_of_order_s));
  }
  if (ordered.num_double > 0) {
    log_warning(fmt::format("{}: {} of {} poses with the stamp of another (or nearly), skipped; the first is at {} s",
                            options.trajectory, ordered.num_double, num_poses, ordered.first_double_s));
  }
  return ordered.trajectory;
}

RigFrame trajectory_frame(const PosesCommandOptions& options, const Rig& rig) {
  if (options.trajectory_frame.empty()) return rig.trajectory_frame;
  return options.trajectory_frame == "body" ? RigFrame::kBody : RigFrame::kLidar;
}

Rigid3 camera_from_sensor(const RigCamera& camera, RigFrame frame, const std::string& path) {
  const std::optional<Rigid3>& transform =
      frame == RigFrame::kBody ? camera.camera_from_body : camera.camera_from_lidar;
  if (!transform) {
    const char* name = frame == RigFrame::kBody ? "body" : "LiDAR";
    throw Error(fmt::format("{}: does not say where camera '{}' is on the {}, whose poses the trajectory has", path,
                            camera.name, name));
  }
  return *transform;
}

/// Whether the image could be read at all. Throws Error where its size is not the camera's.
bool check_size(const std::string& path, const RigCamera& rig_camera, const Camera& camera) {
  ImageSize size;
  try {
    size = read_image_size(path);
  } catch (const Error&) {
    return false;  // has a pose all the same; whoever reads the pixels will say so
  }
  if (size.width == camera.width() && size.height == camera.height()) return true;
  const double scale = static_cast<double>(size.width) / rig_camera.camera.width();
  const bool is_scaled = std::abs(scale * rig_camera.camera.height() - size.height) < 1.0;
  throw Error(fmt::format("{}: is {}x{}, its camera '{}' {}x{}{}", path, size.width, size.height, rig_camera.name,
                          camera.width(), camera.height(),
                          is_scaled ? fmt::format("; image_scale {:.6g} scales the camera", scale) : ""));
}

/// What became of an image.
enum class Outcome { kPosed, kWithoutCamera, kWithoutStamp, kDoubleStamp, kBefore, kAfter, kInGap };

/// Stamps by image name, from a file (by the whole name, else by the last part of it) or from the names.
class StampSource {
 public:
  StampSource(const PosesCommandOptions& options, const std::vector<std::string>& names)
      : unit_(*stamp_unit_from_name(options.stamp_unit)), from_names_(options.stamps.empty()) {
    if (!from_names_) {
      stamps_ = read_image_stamps(options.stamps, unit_);
    } else if (unit_ == StampUnit::kAuto && std::all_of(names.begin(), names.end(), may_be_frame_number)) {
      throw Error(
          fmt::format("{}: names like '{}' seem to count images, not time; give stamps, or stamp_unit if they do",
                      options.images, names.front()));
    }
  }

  std::optional<double> stamp_s(const std::string& name) const {
    if (from_names_) return stamp_of_file_name(name, unit_);
    auto found = stamps_.find(name);
    if (found == stamps_.end()) found = stamps_.find(std::filesystem::path(name).filename().string());
    return found == stamps_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  StampUnit unit_;
  bool from_names_;
  std::map<std::string, double> stamps_;
};

/// The camera whose prefix is the longest that the name begins with.
std::optional<size_t> camera_of(const Rig& rig, const std::string& name) {
  std::optional<size_t> best;
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    if (!name.starts_with(rig.cameras[i].image_prefix)) continue;
    if (!best || rig.cameras[i].image_prefix.size() > rig.cameras[*best].image_prefix.size()) best = i;
  }
  return best;
}

Outcome outcome_of(Coverage coverage) {
  switch (coverage) {
    case Coverage::kBefore:
      return Outcome::kBefore;
    case Coverage::kAfter:
      return Outcome::kAfter;
    case Coverage::kInGap:
      return Outcome::kInGap;
    case Coverage::kCovered:
      break;
  }
  return Outcome::kPosed;
}

class Poser {
 public:
  Poser(const PosesCommandOptions& options, const Rig& rig, const Trajectory& trajectory)
      : options_(options), rig_(rig), trajectory_(trajectory), spline_(trajectory, options.max_gap_s) {
    const RigFrame frame = trajectory_frame(options, rig);
    for (size_t i = 0; i < rig.cameras.size(); ++i) {
      camera_from_sensor_.push_back(camera_from_sensor(rig.cameras[i], frame, options.rig));
      model_.cameras.emplace(camera_id(i), scaled_camera(rig.cameras[i].camera, options.image_scale));
    }
    map_from_sensor_.resize(rig.cameras.size());
    taken_.resize(rig.cameras.size());
    size_checked_.resize(rig.cameras.size(), false);
  }

  void add(const std::string& name, const StampSource& stamps) {
    const std::optional<size_t> camera = camera_of(rig_, name);
    if (!camera) return note(Outcome::kWithoutCamera, name, 0.0);
    const std::optional<double> stamp = stamps.stamp_s(name);
    if (!stamp) return note(Outcome::kWithoutStamp, name, 0.0);
    const RigCamera& rig_camera = rig_.cameras[*camera];
    const double instant = *stamp + rig_camera.time_offset_s + 0.5 * rig_camera.readout_s;
    const Outcome outcome = outcome_of(spline_.coverage(instant));
    if (outcome != Outcome::kPosed) return note(outcome, name, instant);
    if (!taken_[*camera].insert(*stamp).second) return note(Outcome::kDoubleStamp, name, *stamp);
    const Rigid3 map_from_sensor = *spline_.map_from_sensor(instant);
    if (!size_checked_[*camera]) {
      size_checked_[*camera] =
          check_size(image_path(options_.images, name), rig_camera, model_.cameras.at(camera_id(*camera)));
    }
    map_from_sensor_[*camera].push_back(map_from_sensor);
    model_.images.push_back({static_cast<uint32_t>(model_.images.size() + 1), name, camera_id(*camera),
                             camera_from_sensor_[*camera] * inverse(map_from_sensor)});
    stamps_text_ += fmt::format("{} {}\n", name, instant);
    ++counts_[Outcome::kPosed];
  }

  void warn() const {
    const double begin = trajectory_.front().stamp_s;
    const double end = trajectory_.back().stamp_s;
    warn_of(Outcome::kWithoutCamera, "of no camera of the rig skipped", false);
    warn_of(Outcome::kWithoutStamp, "without a stamp skipped", false);
    warn_of(Outcome::kDoubleStamp, "with the stamp of another of the same camera skipped", true);
    warn_of(Outcome::kBefore, fmt::format("before the trajectory, which begins at {} s, skipped", begin), true);
    warn_of(Outcome::kAfter, fmt::format("after the trajectory, which ends at {} s, skipped", end), true);
    warn_of(Outcome::kInGap, fmt::format("in gaps of the trajectory longer than {} s skipped", options_.max_gap_s),
            true);
  }

  void warn_if_not_upright() const {
    const std::optional<Eigen::Vector3d> up = up_axis(options_.up);
    if (!up) return;
    for (size_t i = 0; i < rig_.cameras.size(); ++i) {
      const UprightCheck check = check_upright(camera_from_sensor_[i], map_from_sensor_[i], *up);
      if (!check.mistake) continue;
      log_warning(
          fmt::format("{}: the images of camera '{}' stand {:.0f} deg from upright, but {:.0f} deg if its extrinsic "
                      "is {}; right only if it is mounted so",
                      options_.rig, rig_.cameras[i].name, check.tilt_deg, check.corrected_tilt_deg, *check.mistake));
    }
  }

  PosesSummary summary(size_t num_images) const {
    PosesSummary summary;
    summary.num_images = num_images;
    summary.num_posed = count(Outcome::kPosed);
    summary.num_outside = count(Outcome::kBefore) + count(Outcome::kAfter);
    summary.num_in_gap = count(Outcome::kInGap);
    summary.num_without_stamp = count(Outcome::kWithoutStamp);
    summary.num_double_stamp = count(Outcome::kDoubleStamp);
    summary.num_without_camera = count(Outcome::kWithoutCamera);
    return summary;
  }

  const SparseModel& model() const { return model_; }
  const std::string& stamps_text() const { return stamps_text_; }

 private:
  static uint32_t camera_id(size_t index) { return static_cast<uint32_t>(index + 1); }

  size_t count(Outcome outcome) const {
    const auto found = counts_.find(outcome);
    return found == counts_.end() ? 0 : found->second;
  }

  void note(Outcome outcome, const std::string& name, double stamp_s) {
    if (counts_[outcome]++ == 0) first_[outcome] = {name, stamp_s};
  }

  void warn_of(Outcome outcome, const std::string& what, bool with_stamp) const {
    if (count(outcome) == 0) return;
    const auto& [name, stamp_s] = first_.at(outcome);
    log_warning(fmt::format("{}: {} {}, the first is '{}'{}", options_.images, images_text(count(outcome)), what, name,
                            with_stamp ? fmt::format(" at {} s", stamp_s) : ""));
  }

  const PosesCommandOptions& options_;
  const Rig& rig_;
  const Trajectory& trajectory_;
  TrajectorySpline spline_;
  std::vector<Rigid3> camera_from_sensor_;            // one a camera
  std::vector<std::vector<Rigid3>> map_from_sensor_;  // of each camera's images
  std::vector<std::set<double>> taken_;               // stamps of each camera's images
  std::vector<bool> size_checked_;                    // of one image of each camera
  SparseModel model_;
  std::string stamps_text_;
  std::map<Outcome, size_t> counts_;
  std::map<Outcome, std::pair<std::string, double>> first_;
};

}  // namespace

void PosesCommandOptions::validate() const {
  require_option("trajectory", trajectory);
  require_option("rig", rig);
  require_option("images", images);
  require_option("out", out);
  check_option(max_gap_s > 0.0 && std::isfinite(max_gap_s), "max_gap_s", "(0, inf)", max_gap_s);
  check_option(image_scale > 0.0 && image_scale <= 100.0, "image_scale", "(0, 100]", image_scale);
  if (!stamp_unit_from_name(stamp_unit)) {
    throw UsageError(fmt::format("option stamp_unit must be auto, s, ms, us or ns, got '{}'", stamp_unit));
  }
  if (!trajectory_frame.empty() && trajectory_frame != "lidar" && trajectory_frame != "body") {
    throw UsageError(fmt::format("option trajectory_frame must be lidar or body, got '{}'", trajectory_frame));
  }
  if (up != "none" && !up_axis(up)) {
    throw UsageError(fmt::format("option up must be x, -x, y, -y, z, -z or none, got '{}'", up));
  }
}

PosesSummary poses_command(const PosesCommandOptions& options) {
  options.validate();
  const Rig rig = read_rig(options.rig, options.intrinsics);
  const Trajectory trajectory = read_trajectory(options);
  if (!std::filesystem::is_directory(options.images))
    throw Error(fmt::format("{}: not a folder of images", options.images));
  const std::vector<std::string> names = list_images(options.images);
  if (names.empty()) throw Error(fmt::format("{}: holds no images", options.images));
  const StampSource stamps(options, names);
  Poser poser(options, rig, trajectory);
  for (const std::string& name : names) poser.add(name, stamps);
  poser.warn();
  const PosesSummary summary = poser.summary(names.size());
  if (summary.num_posed == 0) {
    throw Error(fmt::format("{}: none of its {} gets a pose from {} ({} to {} s)", options.images,
                            images_text(names.size()), options.trajectory, trajectory.front().stamp_s,
                            trajectory.back().stamp_s));
  }
  poser.warn_if_not_upright();
  write_sparse_model_text(options.out, poser.model());
  write_text_file(options.out + "/stamps.txt", poser.stamps_text());
  return summary;
}

}  // namespace cpplus
