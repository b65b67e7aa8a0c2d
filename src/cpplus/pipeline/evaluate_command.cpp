#include "cpplus/pipeline/evaluate_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <utility>

#include "cpplus/core/error.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/map_io.h"
#include "cpplus/io/npz_io.h"
#include "cpplus/pipeline/checkerboard_json.h"
#include "cpplus/pipeline/visible_map_points.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

std::set<std::string> read_names(const std::string& path) {
  std::set<std::string> names;
  if (path.empty()) return names;
  std::ifstream file(path);
  if (!file) throw Error(fmt::format("{}: cannot be opened", path));
  for (std::string name; file >> name;) names.insert(name);
  return names;
}

/// A file with arrays `range` (rows x columns, metres along the ray), `step` and `offset` (one number each): column i,
/// row j are pixel (offset + step * i, offset + step * j) in COLMAP's convention.
RangeGrid read_range_grid(const std::string& path) {
  const std::map<std::string, NpyArray> arrays = read_npz(path);
  for (const auto& [name, num_values] : {std::pair<const char*, size_t>{"range", 0}, {"step", 1}, {"offset", 1}}) {
    const auto array = arrays.find(name);
    if (array == arrays.end()) throw Error(fmt::format("{}: array {} is missing", path, name));
    const bool fits = num_values == 0 ? array->second.shape.size() == 2 : array->second.values.size() == num_values;
    if (!fits) throw Error(fmt::format("{}: array {} has a wrong shape", path, name));
  }
  const NpyArray& range = arrays.at("range");
  RangeGrid grid;
  grid.ranges = RangeImage(static_cast<int>(range.shape[1]), static_cast<int>(range.shape[0]));
  std::transform(range.values.begin(), range.values.end(), grid.ranges.pixels.begin(),
                 [](double value) { return static_cast<float>(value); });
  grid.step_px = arrays.at("step").values[0];
  if (!(grid.step_px > 0.0)) throw Error(fmt::format("{}: step must be positive, got {}", path, grid.step_px));
  grid.first_pixel.setConstant(arrays.at("offset").values[0] - 0.5);
  return grid;
}

/// Surface points of an image from its range file, else from the map.
class SurfaceOfImage {
 public:
  explicit SurfaceOfImage(const EvaluateOptions& options) : depth_folder_(options.depth) {
    if (!depth_folder_.empty() && !fs::is_directory(depth_folder_)) {
      throw Error(fmt::format("{}: not a folder", depth_folder_));
    }
    if (!options.depth_poses.empty()) {
      for (const PosedImage& image : read_sparse_model(options.depth_poses).images) {
        depth_poses_.emplace(image.name, image.camera_from_map);
      }
    }
    if (!options.map.empty()) map_ = read_map(options.map, VoxelMapOptions{}).map;
  }

  std::vector<Eigen::Vector3d> operator()(const PosedImage& reference, const Camera& camera) const {
    const fs::path file = fs::path(depth_folder_) / fs::path(reference.name).replace_extension(".npz");
    if (!depth_folder_.empty() && fs::exists(file)) {
      const auto pose = depth_poses_.find(reference.name);
      const Rigid3& depth_pose = pose == depth_poses_.end() ? reference.camera_from_map : pose->second;
      return visible_points_from_ranges(read_range_grid(file.string()), camera, depth_pose);
    }
    if (map_) return visible_map_points(*map_, camera, reference.camera_from_map);
    return {};
  }

 private:
  std::string depth_folder_;
  std::map<std::string, Rigid3> depth_poses_;
  std::optional<VoxelMap> map_;
};

}  // namespace

void EvaluateOptions::validate() const {
  if (estimate.empty()) throw UsageError("option estimate must name a COLMAP model folder");
  if (reference.empty()) throw UsageError("option reference must name a COLMAP model folder");
  if (depth.empty() && !depth_poses.empty()) throw UsageError("option depth_poses has no use without option depth");
}

ModelComparison evaluate_models(const EvaluateOptions& options) {
  options.validate();
  const SparseModel estimate = read_sparse_model(options.estimate);
  const SparseModel reference = read_sparse_model(options.reference);
  std::vector<Checkerboard> boards;
  if (!options.checkerboards.empty()) boards = read_checkerboards(options.checkerboards);
  const ModelComparison comparison =
      compare_models(estimate, reference, SurfaceOfImage(options), boards, read_names(options.exclude));
  if (comparison.images.empty()) {
    throw Error(fmt::format("{} and {} have no image name in common", options.estimate, options.reference));
  }
  return comparison;
}

}  // namespace cpplus
