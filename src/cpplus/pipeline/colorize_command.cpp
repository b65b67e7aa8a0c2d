#include "cpplus/pipeline/colorize_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/options.h"
#include "cpplus/features/blur.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/map_io.h"
#include "cpplus/pipeline/cloud_output.h"
#include "cpplus/pipeline/color_view_depth.h"
#include "cpplus/pipeline/colored_map.h"
#include "cpplus/pipeline/colorize_parts.h"
#include "cpplus/pipeline/drawn_points.h"
#include "cpplus/pipeline/held_out_images.h"
#include "cpplus/pipeline/image_folder.h"
#include "cpplus/pipeline/map_cache.h"
#include "cpplus/pipeline/map_near_images.h"
#include "cpplus/report/colorize_report.h"
#include "cpplus/report/render_cloud.h"

namespace cpplus {

namespace {

/// Edge of the square that a point is drawn as, in leaves.
constexpr double kPointLeaves = 0.4;

/// A motion-blurred image gives colours where no sharp one does.
constexpr double kBlurredWeight = 0.1;

/// An image with what the map hides from it; nothing, with a warning, where it cannot be used.
std::optional<ColorView> read_view(const ColorizeCommandOptions& options, const SparseModel& model,
                                   const PosedImage& posed, const VoxelMap& map) {
  const std::string path = image_path(options.images, posed.name);
  const Camera& camera = model.cameras.at(posed.camera_id);
  ColorView view;
  try {
    view.image = read_color_image(path);
  } catch (const Error& error) {
    log_warning(fmt::format("skipped: {}", error.what()));
    return std::nullopt;
  }
  if (view.image.width != camera.width() || view.image.height != camera.height()) {
    log_warning(fmt::format("skipped: {}: is {}x{}, its camera {} is {}x{}", path, view.image.width, view.image.height,
                            posed.camera_id, camera.width(), camera.height()));
    return std::nullopt;
  }
  view.name = posed.name;
  view.image_id = posed.id;
  view.camera_id = posed.camera_id;
  if (measure_blur(to_gray(view.image), {}).blurred) view.weight = kBlurredWeight;
  view.camera = camera;
  view.camera_from_map = posed.camera_from_map;
  view.depth = color_view_depth(map, camera, posed.camera_from_map, options.color.sampling.max_distance_m);
  return view;
}

/// Of the images that give colours and of those that are held out.
std::vector<Eigen::Vector3d> places_to_look_from(const SparseModel& model, const SparseModel& held_out_model) {
  std::vector<Eigen::Vector3d> places = camera_centers(model);
  const std::vector<Eigen::Vector3d> more = camera_centers(held_out_model);
  places.insert(places.end(), more.begin(), more.end());
  return places;
}

/// Says what the images could not tell.
void log_exposure(const ColorizeResult& result) {
  const auto num_unknown = std::count_if(result.images.begin(), result.images.end(),
                                         [](const ColorizedImage& image) { return !image.exposure.determined; });
  if (num_unknown > 0) {
    log_info(fmt::format("exposure: {} of {} images share too few points with others and keep theirs", num_unknown,
                         result.images.size()));
  }
  for (const auto& [id, vignetting] : result.vignetting) {
    if (vignetting.determined) continue;
    log_info(fmt::format("vignetting of camera {}: not determined by these images, taken as none", id));
  }
}

/// The photo beside the coloured cloud from the same pose: DIR/STEM.png with the folders of NAME joined by "_".
void write_debug_images(const ColorizeCommandOptions& options, const SparseModel& model,
                        const std::vector<size_t>& images, const ColoredCloud& cloud, double point_size_m) {
  std::filesystem::create_directories(options.debug_images);
  for (const size_t index : images) {
    const PosedImage& posed = model.images[index];
    const Camera& camera = model.cameras.at(posed.camera_id);
    const DepthBuffer surface =
        color_view_depth(cloud.points.map, camera, posed.camera_from_map, options.color.sampling.max_distance_m);
    const ColorImage rendering =
        render_cloud(drawn_points(cloud, surface, posed.camera_from_map), surface, posed.camera_from_map, point_size_m);
    const ColorImage photo = read_color_image(image_path(options.images, posed.name));
    write_png(image_path(options.debug_images, debug_image_name(posed.name)), side_by_side(photo, rendering));
  }
}

}  // namespace

void ColorizeCommandOptions::validate() const {
  require_option("map", map);
  require_option("images", images);
  require_option("poses", poses);
  require_option("out", out);
  check_option(hold_out >= 0 && hold_out != 1, "hold_out", "0 or [2, inf)", hold_out);
  check_option(max_part_points >= 1, "max_part_points", "[1, inf)", max_part_points);
  voxel_map.validate();
  color.validate();
}

ColorizeSummary run_colorize(const ColorizeCommandOptions& options) {
  options.validate();
  check_cloud_output(options.out);
  const SparseModel model = read_sparse_model(options.poses);
  const ImageFolder folder = find_images(options.images, model);
  warn_of_unmatched(options.images, model, folder);
  const HeldOutSplit split = split_images(folder.with_file, options.hold_out);
  const SparseModel held_out_model = options.hold_out_poses.empty() ? model : read_sparse_model(options.hold_out_poses);
  const std::string path = cached_map(options.map, options.cache, options.voxel_map);
  const PointMap points = read_map(path, options.voxel_map);
  const double point_size_m = kPointLeaves * points.map.options().leaf_size_m;
  const GrayScale grays(points.intensities);
  const ColorImages images{model, split.colored,
                           [&](size_t i) { return read_view(options, model, model.images[i], points.map); }};
  const auto [result, used, colors] = colorize_in_parts(
      path, points,
      roots_near_places(points.map, places_to_look_from(model, held_out_model), options.color.sampling.max_distance_m),
      images, options.color, static_cast<size_t>(options.max_part_points), options.out);
  const ColoredCloud cloud{points, colors, grays};
  if (used.empty()) throw Error(fmt::format("{}: none of the model's images can be used", options.images));
  if (result.num_colored == 0) {
    throw Error(fmt::format("{}: no image sees a point of {} within {} m; same frame, and metres?", options.poses,
                            options.map, options.color.sampling.max_distance_m));
  }
  if (options.color.exposure.gains && options.color.exposure.vignetting) log_exposure(result);
  write_colored_map(path, points, colors, grays, options.out);
  const std::vector<HeldOutImage> held_out =
      compare_held_out(options.images, model, split.held_out, held_out_model, cloud, result,
                       {options.color.sampling.max_distance_m, point_size_m});
  if (!options.report.empty()) write_text_file(options.report, colorize_report_json(result, held_out));
  if (!options.debug_images.empty()) write_debug_images(options, model, used, cloud, point_size_m);
  const auto num_judges = static_cast<size_t>(
      std::count_if(held_out.begin(), held_out.end(), [](const HeldOutImage& image) { return !image.blurred; }));
  return {points.map.num_points(),
          result.num_colored,
          used.size(),
          model.images.size() - used.size() - split.held_out.size(),
          num_judges,
          total_difference(held_out)};
}

}  // namespace cpplus
