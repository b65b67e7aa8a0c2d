#include "cpplus/pipeline/colorize_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/progress.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/pipeline/image_folder.h"
#include "cpplus/visibility/depth_buffer.h"

namespace cpplus {
namespace {

/// Finer cells would leave gaps between the leaves of near surfaces, coarser ones blur the edges that colours must not
/// cross.
constexpr double kDepthCellPx = 2.0;

DepthBuffer depth_of_view(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                          double max_distance_m) {
  DepthBufferOptions options;
  options.max_distance_m = max_distance_m;
  options.cell_leaves = kDepthCellPx * max_distance_m / (map.options().leaf_size_m * camera.pixels_per_radian());
  return render_depth_buffer(map, camera, camera_from_map, options);
}

/// Decodes the images of a model one after the other; one that cannot be read is warned of and left out.
class ViewReader {
 public:
  ViewReader(const ColorizeCommandOptions& options, const SparseModel& model, const ImageFolder& folder,
             const VoxelMap& map)
      : options_(options), model_(model), folder_(folder), map_(map), progress_("colour", folder.with_file.size()) {}

  std::optional<ColorView> next() {
    while (next_ < folder_.with_file.size()) {
      const PosedImage& image = model_.images[folder_.with_file[next_++]];
      progress_.advance();
      ColorView view;
      view.name = image.name;
      view.camera = model_.cameras.at(image.camera_id);
      view.camera_from_map = image.camera_from_map;
      try {
        view.image = read_color_image(image_path(options_.images, image.name));
      } catch (const Error& error) {
        log_warning(fmt::format("left out: {}", error.what()));
        continue;
      }
      view.depth = depth_of_view(map_, view.camera, view.camera_from_map, options_.colorize.sampling.max_distance_m);
      return view;
    }
    return {};
  }

 private:
  const ColorizeCommandOptions& options_;
  const SparseModel& model_;
  const ImageFolder& folder_;
  const VoxelMap& map_;
  Progress progress_;
  size_t next_ = 0;
};

}  // namespace

void ColorizeCommandOptions::validate() const {
  for (const auto& [name, value] :
       {std::pair<const char*, const std::string&>{"map", map}, {"images", images}, {"poses", poses}, {"out", out}}) {
    if (value.empty()) throw UsageError(fmt::format("option {} must be given", name));
  }
  if (point_cloud_extension(out).empty()) {
    throw UsageError(fmt::format("option out must end in .ply, .pcd or .las, got {}", out));
  }
  colorize.validate();
}

ColorizeSummary colorize_map(const ColorizeCommandOptions& options) {
  options.validate();
  const SparseModel model = read_sparse_model(options.poses);
  const ImageFolder folder = find_images(options.images, model);
  warn_of_unmatched(options.images, model, folder);
  PointCloud cloud = read_point_cloud(options.map);
  const VoxelMap map(cloud, {});

  ColorizeResult result;
  {
    ViewReader reader(options, model, folder, map);
    result = colorize(
        std::move(cloud), map, [&reader] { return reader.next(); }, options.colorize);
  }
  if (result.num_images == 0) throw Error(fmt::format("{}: none of the model's images can be read", options.images));
  write_point_cloud(options.out, result.cloud);
  return {result.cloud.size(), result.num_colored, result.num_images, folder.missing.size()};
}

}  // namespace cpplus
