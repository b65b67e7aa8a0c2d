#include "cpplus/pipeline/import_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/options.h"
#include "cpplus/core/progress.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_stamps.h"
#include "cpplus/io/imported_project.h"
#include "cpplus/io/kitti_scan.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/pose_file.h"
#include "cpplus/io/rig_io.h"
#include "cpplus/io/trajectory_io.h"
#include "cpplus/pipeline/image_folder.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

/// Reads the source; the folder is for what has to be unpacked.
using Importer = std::function<ImportedProject(const ImportCommandOptions&, const std::string& folder)>;

const std::map<std::string, Importer>& importers() {
  static const std::map<std::string, Importer> all = {
      {"colmap", [](const auto& o, const auto&) { return import_colmap(o.source); }},
      {"nerfstudio", [](const auto& o, const auto&) { return import_nerfstudio(o.source); }},
      {"kitti", [](const auto& o, const auto&) { return import_kitti_odometry(o.source); }},
      {"kitti-raw", [](const auto& o, const auto&) { return import_kitti_raw(o.source); }},
      {"fast-livo2", [](const auto& o, const auto&) { return import_fast_livo2(o.source, o.rig, o.intrinsics); }},
      {"global-lvba", [](const auto& o, const auto&) { return import_global_lvba(o.source, o.rig, o.intrinsics); }},
      {"lio-sam", [](const auto& o, const auto&) { return import_lio_sam(o.source); }},
      {"rosbag",
       [](const auto& o, const auto& folder) {
         return import_rosbag(o.source, {o.image_topic, o.lidar_topic, o.pose_topic}, folder);
       }},
      {"r3live", [](const auto& o, const auto&) { return import_r3live(o.source); }},
  };
  return all;
}

bool has_extrinsics(const Rig& rig) {
  const auto is_placed = [](const RigCamera& camera) { return camera.camera_from_lidar || camera.camera_from_body; };
  return std::all_of(rig.cameras.begin(), rig.cameras.end(), is_placed);
}

/// What the user names goes before what the source holds.
void apply_overrides(const ImportCommandOptions& options, ImportedProject* project) {
  if (!options.map.empty()) project->map = options.map;
  if (!options.images.empty()) {
    if (!fs::is_directory(options.images)) throw Error(fmt::format("{}: not a folder of images", options.images));
    project->images.clear();
    for (const std::string& name : list_images(options.images)) {
      project->images.push_back({image_path(options.images, name), name});
    }
  }
  if (!options.trajectory.empty()) {
    const OrderedTrajectory ordered = order_by_stamp(read_pose_file(options.trajectory, options.times));
    project->trajectory = ordered.trajectory;
    if (ordered.num_double > 0) {
      project->notes.push_back(fmt::format("{}: {} of {} poses with the stamp of another, left out", options.trajectory,
                                           ordered.num_double, ordered.num_double + ordered.trajectory.size()));
    }
  }
  if (!options.stamps.empty()) project->stamps_s = read_image_stamps(options.stamps, StampUnit::kAuto);
  // An importer that took the rig has corrected it by what the images say.
  const bool rig_is_taken = project->rig && has_extrinsics(*project->rig);
  if (!options.rig.empty() && !rig_is_taken) project->rig = read_rig(options.rig, options.intrinsics);
}

/// A folder that is renamed to its place when it is whole, and removed otherwise.
class AtomicFolder {
 public:
  explicit AtomicFolder(const std::string& path) : target_(fs::absolute(path).lexically_normal()) {
    if (!target_.has_filename()) target_ = target_.parent_path();
    std::error_code failure;
    if (fs::exists(target_) && (!fs::is_directory(target_) || !fs::is_empty(target_, failure))) {
      throw Error(fmt::format("{}: is there already; an import makes a new folder", path));
    }
    temporary_ = target_.parent_path() / fmt::format(".{}.{}.partial", target_.filename().string(), getpid());
    fs::remove_all(temporary_, failure);
    fs::create_directories(temporary_, failure);
    if (failure) throw Error(fmt::format("{}: cannot make the folder: {}", path, failure.message()));
  }
  ~AtomicFolder() {
    std::error_code ignored;
    if (!committed_) fs::remove_all(temporary_, ignored);
  }
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  const fs::path& temporary() const { return temporary_; }
  const fs::path& target() const { return target_; }

  void commit() {
    std::error_code failure;
    fs::remove(target_, failure);  // an empty folder may stand there
    fs::rename(temporary_, target_, failure);
    if (failure) throw Error(fmt::format("{}: cannot write: {}", target_.string(), failure.message()));
    committed_ = true;
  }

 private:
  fs::path target_;
  fs::path temporary_;
  bool committed_ = false;
};

class ProjectWriter {
 public:
  ProjectWriter(const ImportCommandOptions& options, const ImportedProject& project, AtomicFolder* folder)
      : options_(options), project_(project), folder_(*folder) {}

  void write() {
    if (!project_.map.empty()) place(project_.map, map_name());
    write_images();
    write_scans();
    if (!project_.stamps_s.empty()) write_text_file(path("stamps.txt"), stamps_text());
    if (!project_.trajectory.empty()) write_tum(path("trajectory.txt"), project_.trajectory);
    if (project_.rig) write_rig(path(has_extrinsics(*project_.rig) ? "rig.yaml" : "cameras.yaml"), *project_.rig);
    if (project_.model) write_sparse_model_text(path("coarse"), *project_.model);
    write_text_file(path("project.yaml"), project_yaml());
    folder_.commit();
  }

 private:
  std::string path(const std::string& name) const { return (folder_.temporary() / name).string(); }
  std::string final_path(const std::string& name) const { return (folder_.target() / name).string(); }
  std::string map_name() const { return "map" + fs::path(project_.map).extension().string(); }

  /// Links or copies a file into the project.
  void place(const std::string& source, const std::string& name) const {
    const fs::path target = path(name);
    std::error_code failure;
    if (fs::path(source) == target) return;  // unpacked into its place
    if (!fs::is_regular_file(source)) throw Error(fmt::format("{}: no such file", source));
    fs::create_directories(target.parent_path(), failure);
    if (!failure && options_.copy) fs::copy_file(source, target, failure);
    if (!failure && !options_.copy) fs::create_symlink(fs::canonical(source), target, failure);
    if (failure) throw Error(fmt::format("{}: cannot bring it to {}: {}", source, final_path(name), failure.message()));
  }

  void write_images() const {
    Progress progress("images", project_.images.size());
    for (const SourceFile& image : project_.images) {
      place(image.path, "images/" + image.name);
      progress.advance();
    }
  }

  void write_scans() const {
    Progress progress("scans", project_.scans.size());
    for (const SourceFile& scan : project_.scans) {
      if (scan.path.ends_with(".bin")) {
        write_point_cloud(path("scans/" + fs::path(scan.name).replace_extension(".pcd").string()),
                          read_kitti_scan(scan.path));
      } else {
        place(scan.path, "scans/" + scan.name);
      }
      progress.advance();
    }
    if (!project_.scans.empty()) write_tum(path("scans/poses.txt"), project_.scan_poses);
  }

  std::string stamps_text() const {
    std::string text;
    for (const auto& [name, stamp_s] : project_.stamps_s) text += fmt::format("{} {}\n", name, stamp_s);
    return text;
  }

  /// A path as text of YAML.
  std::string quoted(const std::string& name) const {
    std::string text = "\"";
    for (const char c : final_path(name)) text += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    return text + "\"";
  }

  std::string section(const std::string& name, const std::vector<std::pair<std::string, std::string>>& keys) const {
    std::string text = name + ":\n";
    for (const auto& [key, value] : keys) text += fmt::format("  {}: {}\n", key, quoted(value));
    return text;
  }

  std::string project_yaml() const {
    std::string text = fmt::format(
        "# Made by `cpplus import {}`. Each command takes its section: cpplus refine --config FILE\n", options_.format);
    const bool can_pose = project_.rig && has_extrinsics(*project_.rig) && !project_.trajectory.empty() &&
                          !project_.images.empty() && !project_.model;
    if (can_pose) {
      std::vector<std::pair<std::string, std::string>> keys = {
          {"trajectory", "trajectory.txt"}, {"rig", "rig.yaml"}, {"images", "images"}, {"out", "coarse"}};
      if (!project_.stamps_s.empty()) keys.insert(keys.begin() + 3, {"stamps", "stamps.txt"});
      text += section("poses", keys);
    }
    // Without a map the scans make one, of what stands still.
    const bool makes_map = project_.map.empty() && !project_.scans.empty();
    const std::string map = makes_map ? "static_map.pcd" : map_name();
    if (makes_map) text += section("clean", {{"scans", "scans"}, {"poses", "scans/poses.txt"}, {"out", map}});
    if ((project_.map.empty() && !makes_map) || project_.images.empty() || (!project_.model && !can_pose)) return text;
    std::vector<std::pair<std::string, std::string>> keys = {{"map", map}, {"images", "images"}, {"poses", "coarse"}};
    if (can_pose) {
      keys.emplace_back("stamps", "coarse/stamps.txt");
    } else if (!project_.stamps_s.empty()) {
      keys.emplace_back("stamps", "stamps.txt");
    }
    if ((can_pose || !project_.stamps_s.empty()) && !project_.trajectory.empty())
      keys.emplace_back("trajectory", "trajectory.txt");
    keys.emplace_back("out", "refined");
    text += section("refine", keys);
    text +=
        section("colorize", {{"map", map}, {"images", "images"}, {"poses", "refined/sparse"}, {"out", "coloured.ply"}});
    return text;
  }

  const ImportCommandOptions& options_;
  const ImportedProject& project_;
  AtomicFolder& folder_;
};

void check_names(const ImportedProject& project, const std::string& source) {
  std::set<std::string> names;
  for (const SourceFile& image : project.images) {
    if (!names.insert(image.name).second) {
      throw Error(fmt::format("{}: two images would be called '{}' in the project", source, image.name));
    }
  }
}

}  // namespace

void ImportCommandOptions::validate() const {
  // Format and source may be positional arguments, which join these options later: import_command() looks at them.
}

ImportSummary import_command(const ImportCommandOptions& options) {
  require_option("format", options.format);
  require_option("source", options.source);
  require_option("out", options.out);
  const auto importer = importers().find(options.format);
  if (importer == importers().end()) {
    std::vector<std::string> known;
    for (const auto& [name, function] : importers()) known.push_back(name);
    throw UsageError(fmt::format("unknown format '{}': known are {}", options.format, fmt::join(known, ", ")));
  }
  if (!fs::exists(options.source)) throw Error(fmt::format("{}: no such file or folder", options.source));
  AtomicFolder folder(options.out);
  ImportedProject project = importer->second(options, folder.temporary().string());
  apply_overrides(options, &project);
  check_names(project, options.source);
  ProjectWriter(options, project, &folder).write();
  for (const std::string& note : project.notes) log_warning(note);
  if (project.rig && !has_extrinsics(*project.rig)) {
    log_warning(fmt::format("{}: cameras.yaml has no extrinsics; with camera_from_lidar it is a rig", options.out));
  }

  ImportSummary summary;
  summary.has_map = !project.map.empty();
  summary.num_images = project.images.size();
  summary.num_posed = project.model ? project.model->images.size() : 0;
  summary.num_stamps = project.stamps_s.size();
  summary.num_trajectory_poses = project.trajectory.size();
  summary.num_scans = project.scans.size();
  return summary;
}

}  // namespace cpplus
