#include "cpplus/pipeline/export_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/options.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/stamps_io.h"
#include "cpplus/io/trajectory_io.h"
#include "cpplus/pipeline/atomic_folder.h"
#include "cpplus/pipeline/export_potree.h"
#include "cpplus/pipeline/export_scene.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

/// What a format cannot do without.
struct Needs {
  bool map = false;
  bool images = false;
  bool stamps = false;
  bool poses = true;
};

const std::map<std::string, Needs>& formats() {
  static const std::map<std::string, Needs> all = {{"colmap-text", {.map = true, .images = true}},
                                                   {"colmap-bin", {.map = true, .images = true}},
                                                   {"undistorted", {.images = true}},
                                                   {"3dgs", {.map = true, .images = true}},
                                                   {"nerfstudio", {.map = true, .images = true}},
                                                   {"depth", {.map = true}},
                                                   {"normals", {.map = true}},
                                                   {"potree", {.map = true, .poses = false}},
                                                   {"tum", {.stamps = true}},
                                                   {"kitti", {}}};
  return all;
}

/// Mean of the camera centres, whole metres.
Eigen::Vector3d origin_near(const SparseModel& model) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const PosedImage& image : model.images) sum += camera_center(image.camera_from_map);
  return (sum / static_cast<double>(std::max<size_t>(1, model.images.size()))).array().round();
}

/// One camera's poses in time, or in the order of the model where there are no stamps.
struct CameraTrajectory {
  Trajectory map_from_camera;
  std::vector<std::string> names;
};

std::map<uint32_t, CameraTrajectory> trajectories_of(const ExportCommandOptions& options, const SparseModel& model,
                                                     const Eigen::Vector3d& origin) {
  std::map<std::string, double> stamps_s;
  if (!options.stamps.empty()) stamps_s = read_stamps(options.stamps);
  std::vector<std::pair<double, const PosedImage*>> images;
  for (const PosedImage& image : model.images) {
    const auto stamp = stamps_s.find(image.name);
    if (options.stamps.empty() || stamp != stamps_s.end())
      images.emplace_back(options.stamps.empty() ? 0.0 : stamp->second, &image);
  }
  if (images.empty()) {
    throw Error(options.stamps.empty()
                    ? fmt::format("{}: holds no images", options.poses)
                    : fmt::format("{}: has no stamp of an image of {}", options.stamps, options.poses));
  }
  std::stable_sort(images.begin(), images.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::map<uint32_t, CameraTrajectory> trajectories;
  for (const auto& [stamp_s, image] : images) {
    CameraTrajectory& of_camera = trajectories[image->camera_id];
    if (options.format == "tum" && !of_camera.names.empty() && of_camera.map_from_camera.back().stamp_s == stamp_s) {
      throw Error(fmt::format("{}: {} and {} of camera {} have the same stamp {}", options.stamps,
                              of_camera.names.back(), image->name, image->camera_id, stamp_s));
    }
    Rigid3 map_from_camera = inverse(image->camera_from_map);
    map_from_camera.translation -= origin;
    of_camera.map_from_camera.push_back({stamp_s, map_from_camera});
    of_camera.names.push_back(image->name);
  }
  return trajectories;
}

/// tum: trajectory.txt. kitti: poses.txt, images.txt with the name of each row, and times.txt where there are stamps.
/// Of several cameras each has its own, poses_ID.txt.
ExportSummary export_trajectories(const ExportCommandOptions& options, const SparseModel& model,
                                  const Eigen::Vector3d& origin, const fs::path& folder) {
  const auto trajectories = trajectories_of(options, model, origin);
  ExportSummary summary;
  for (const auto& [camera_id, trajectory] : trajectories) {
    const auto path = [&, id = camera_id](const std::string& stem) {
      return (folder / (trajectories.size() == 1 ? stem + ".txt" : fmt::format("{}_{}.txt", stem, id))).string();
    };
    summary.num_images += trajectory.names.size();
    if (options.format == "tum") {
      write_tum(path("trajectory"), trajectory.map_from_camera);
      continue;
    }
    write_kitti(path("poses"), trajectory.map_from_camera);
    if (!options.stamps.empty()) write_times(path("times"), trajectory.map_from_camera);
    write_text_file(path("images"), fmt::format("{}\n", fmt::join(trajectory.names, "\n")));
  }
  summary.num_skipped = model.images.size() - summary.num_images;
  if (summary.num_skipped > 0) {
    log_warning(fmt::format("{}: {} of {} images have no stamp, left out", options.stamps, summary.num_skipped,
                            model.images.size()));
  }
  return summary;
}

void check_kinds(const ExportCommandOptions& options) {
  if (formats().count(options.format) == 0) {
    std::vector<std::string> known;
    for (const auto& [name, needs] : formats()) known.push_back(name);
    throw UsageError(fmt::format("unknown format '{}': known are {}", options.format, fmt::join(known, ", ")));
  }
  if (options.depth_kind != "z" && options.depth_kind != "range") {
    throw UsageError(fmt::format("option depth_kind must be z or range, got {}", options.depth_kind));
  }
}

}  // namespace

void ExportCommandOptions::validate() const {
  require_option("format", format);
  require_option("out", out);
  check_kinds(*this);
  const Needs& needs = formats().at(format);
  if (needs.poses || local_origin) require_option("poses", poses);
  if (needs.map) require_option("map", map);
  if (needs.images) require_option("images", images);
  if (needs.stamps) require_option("stamps", stamps);
  check_option(jpeg_quality >= 1 && jpeg_quality <= 100, "jpeg_quality", "[1, 100]", jpeg_quality);
  tracks.validate();
  sampling.validate();
  undistort.validate();
  surface.validate();
  voxel_map.validate();
}

namespace {

void check_is_new(const std::string& out) {
  std::error_code failure;
  if (fs::exists(out) && (!fs::is_directory(out) || !fs::is_empty(out, failure))) {
    throw Error(fmt::format("{}: is there already; an export makes a new folder", out));
  }
}

}  // namespace

ExportSummary run_export(const ExportCommandOptions& options) {
  options.validate();
  const bool has_model = formats().at(options.format).poses || options.local_origin;
  const SparseModel model = has_model ? read_sparse_model(options.poses) : SparseModel();
  check_is_new(options.out);
  AtomicFolder folder(options.out);
  const fs::path& target = folder.temporary();
  const Eigen::Vector3d origin = options.local_origin ? origin_near(model) : Eigen::Vector3d(0, 0, 0);
  const std::string& format = options.format;
  ExportSummary summary;
  if (format == "tum" || format == "kitti") {
    summary = export_trajectories(options, model, origin, target);
  } else if (format == "depth" || format == "normals") {
    summary = export_surface_maps(options, model, target);
  } else if (format == "potree") {
    summary = export_potree(options, origin, target);
  } else if (format == "nerfstudio") {
    summary = export_nerfstudio(options, model, origin, target);
  } else if (format == "undistorted" || format == "3dgs") {
    summary = export_undistorted(options, model, origin, target);
  } else {
    summary = export_colmap(options, model, origin, target);
  }
  if (options.local_origin) {
    write_text_file((target / "origin.txt").string(), fmt::format("{} {} {}\n", origin.x(), origin.y(), origin.z()));
  }
  folder.commit();
  return summary;
}

}  // namespace cpplus
