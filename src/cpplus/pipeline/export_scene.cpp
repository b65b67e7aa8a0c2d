#include "cpplus/pipeline/export_scene.h"

#include <fmt/format.h>

#include <functional>
#include <numeric>
#include <optional>

#include "cpplus/core/error.h"
#include "cpplus/core/progress.h"
#include "cpplus/features/blur.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/map_io.h"
#include "cpplus/io/nerfstudio_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/pipeline/color_view_depth.h"
#include "cpplus/pipeline/export_surfaces.h"
#include "cpplus/pipeline/export_views.h"
#include "cpplus/pipeline/image_folder.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

constexpr double kBlurredWeight = 0.1;

/// What is done with the pixels of a view besides its tracks.
using OnView = std::function<void(const ExportView& view, const ColorImage& pixels)>;

std::vector<size_t> images_with_file(const ExportCommandOptions& options, const SparseModel& model) {
  const ImageFolder folder = find_images(options.images, model);
  warn_of_unmatched(options.images, model, folder);
  return folder.with_file;
}

ColorView color_view(const ExportCommandOptions& options, const VoxelMap& map, const ExportView& view,
                     const Camera& camera, ColorImage pixels) {
  ColorView result;
  result.name = view.image.name;
  if (measure_blur(to_gray(pixels), {}).blurred) result.weight = kBlurredWeight;
  result.image = std::move(pixels);
  result.camera = camera;
  result.camera_from_map = view.image.camera_from_map;
  result.depth = color_view_depth(map, camera, result.camera_from_map, options.sampling.max_distance_m);
  return result;
}

/// The model of all views whose images can be read, with the points of the map that they see (none without a map).
/// Images come one after the other.
SparseModel gather_model(const ExportCommandOptions& options, const SparseModel& model, const ExportViews& views,
                         const VoxelMap* map, const OnView& on_view) {
  SparseModel result;
  result.cameras = views.cameras;
  ExportImages images(options.images, model, views);
  std::optional<MapTracks> tracks;
  if (map) tracks.emplace(*map, options.tracks, options.sampling);
  Progress progress("export", views.views.size());
  for (const ExportView& view : views.views) {
    if (std::optional<ColorImage> pixels = images.read(view)) {
      if (on_view) on_view(view, *pixels);
      const Camera& camera = views.cameras.at(view.image.camera_id);
      if (tracks) tracks->add_view(color_view(options, *map, view, camera, std::move(*pixels)), view.image.id);
      result.images.push_back(view.image);
    }
    progress.advance();
  }
  if (result.images.empty()) throw Error(fmt::format("{}: none of the model's images can be used", options.images));
  if (!tracks) return result;
  result.points = tracks->take();
  if (result.points.empty()) {
    throw Error(fmt::format("{}: no point of {} is seen by {} images within {} m; same frame, and metres?",
                            options.poses, options.map, options.tracks.min_views, options.sampling.max_distance_m));
  }
  return result;
}

void move_origin(const Eigen::Vector3d& origin, SparseModel* model) {
  for (PosedImage& image : model->images) image.camera_from_map.translation = image.camera_from_map * origin;
  for (SparsePoint& point : model->points) point.position -= origin;
}

size_t num_sources(const ExportViews& views, const SparseModel& written) {
  // Views and images of one source follow each other, in the same order.
  size_t count = 0;
  size_t next = 0;
  std::optional<size_t> last;
  for (const ExportView& view : views.views) {
    if (next == written.images.size() || written.images[next].id != view.image.id) continue;
    ++next;
    if (last != view.source) ++count;
    last = view.source;
  }
  return count;
}

ExportSummary summary_of(const SparseModel& model, const ExportViews& views, const SparseModel& written) {
  ExportSummary summary;
  summary.num_images = written.images.size();
  summary.num_skipped = model.images.size() - num_sources(views, written);
  summary.num_points = written.points.size();
  for (const SparsePoint& point : written.points) summary.num_observations += point.track.size();
  return summary;
}

/// "left/a.jpg" -> "left/a.png".
std::string map_name(const std::string& name, const char* extension) {
  return fs::path(name).replace_extension(extension).generic_string();
}

PointCloud cloud_of(const SparseModel& model) {
  PointCloud cloud;
  if (model.points.empty()) return cloud;
  // Whole metres, so that coordinates near zero keep the origin 0 and floats in the file.
  const Eigen::Vector3d first = model.points.front().position;
  constexpr double kNear = 1000.0;
  cloud.origin = first.unaryExpr([](double x) { return std::abs(x) < kNear ? 0.0 : std::round(x); });
  for (const SparsePoint& point : model.points) {
    cloud.positions.push_back((point.position - cloud.origin).cast<float>());
    cloud.colors.push_back(point.color);
  }
  return cloud;
}

}  // namespace

ExportSummary export_colmap(const ExportCommandOptions& options, const SparseModel& model,
                            const Eigen::Vector3d& origin, const fs::path& folder) {
  const ExportViews views = recorded_views(model, images_with_file(options, model));
  const VoxelMap map = read_map(options.map, options.voxel_map).map;
  SparseModel written = gather_model(options, model, views, &map, nullptr);
  move_origin(origin, &written);
  const auto write = options.format == "colmap-bin" ? write_sparse_model_binary : write_sparse_model_text;
  write(folder.string(), written);
  return summary_of(model, views, written);
}

ExportSummary export_undistorted(const ExportCommandOptions& options, const SparseModel& model,
                                 const Eigen::Vector3d& origin, const fs::path& folder) {
  PinholeViewOptions undistort = options.undistort;
  undistort.centered = options.format == "3dgs";
  const ExportViews views = undistorted_views(model, images_with_file(options, model), undistort);
  std::optional<VoxelMap> map;
  if (!options.map.empty()) map = read_map(options.map, options.voxel_map).map;
  const ExportImages writer(options.images, model, views);
  const OnView write_image = [&](const ExportView& view, const ColorImage& pixels) {
    writer.write(view, pixels, (folder / "images" / view.image.name).string(), options.jpeg_quality);
  };
  SparseModel written = gather_model(options, model, views, map ? &*map : nullptr, write_image);
  move_origin(origin, &written);
  if (options.format == "3dgs") {
    write_sparse_model_binary((folder / "sparse" / "0").string(), written);
  } else {
    write_sparse_model_text((folder / "sparse").string(), written);
  }
  return summary_of(model, views, written);
}

ExportSummary export_nerfstudio(const ExportCommandOptions& options, const SparseModel& model,
                                const Eigen::Vector3d& origin, const fs::path& folder) {
  const ExportViews views = undistorted_views(model, images_with_file(options, model), options.undistort);
  const VoxelMap map = read_map(options.map, options.voxel_map).map;
  SurfaceRenderer renderer(map, options.surface);
  const ExportImages writer(options.images, model, views);
  std::vector<NerfstudioFrame> frames;
  const OnView write_frame = [&](const ExportView& view, const ColorImage& pixels) {
    const Camera& camera = views.cameras.at(view.image.camera_id);
    const std::string image = "images/" + view.image.name;
    const std::string depth = "depths/" + map_name(view.image.name, ".png");
    writer.write(view, pixels, (folder / image).string(), options.jpeg_quality);
    const SurfaceView surface = renderer.render(view.image.camera_id, camera, view.image.camera_from_map);
    write_png16((folder / depth).string(),
                depth_in_mm(depth_of(surface, renderer.bearings(view.image.camera_id, camera), "z")));
    frames.push_back({image, depth, camera, {}});
  };
  SparseModel written = gather_model(options, model, views, &map, write_frame);
  move_origin(origin, &written);
  for (size_t i = 0; i < frames.size(); ++i) frames[i].camera_from_map = written.images[i].camera_from_map;
  write_point_cloud((folder / "sparse.ply").string(), cloud_of(written));
  write_nerfstudio((folder / "transforms.json").string(), frames, "sparse.ply");
  return summary_of(model, views, written);
}

ExportSummary export_surface_maps(const ExportCommandOptions& options, const SparseModel& model,
                                  const fs::path& folder) {
  for (const auto& [id, camera] : model.cameras) {
    if (camera.model() == CameraModel::kEquirectangular && options.format == "depth" && options.depth_kind == "z") {
      throw Error(
          fmt::format("{}: camera {} is EQUIRECTANGULAR, which has no z; take --depth-kind range", options.poses, id));
    }
  }
  std::vector<size_t> all(model.images.size());
  std::iota(all.begin(), all.end(), size_t{0});
  const ExportViews views = recorded_views(model, all);
  const VoxelMap map = read_map(options.map, options.voxel_map).map;
  SurfaceRenderer renderer(map, options.surface);
  Progress progress(options.format, views.views.size());
  for (const ExportView& view : views.views) {
    const Camera& camera = views.cameras.at(view.image.camera_id);
    const SurfaceView surface = renderer.render(view.image.camera_id, camera, view.image.camera_from_map);
    const std::string path = (folder / map_name(view.image.name, options.exr ? ".exr" : ".png")).string();
    if (fs::exists(path)) throw Error(fmt::format("two images would be called '{}' in the export", path));
    if (options.format == "depth") {
      const Image<float> depth = depth_of(surface, renderer.bearings(view.image.camera_id, camera), options.depth_kind);
      options.exr ? write_exr(path, depth) : write_png16(path, depth_in_mm(depth));
    } else {
      options.exr ? write_exr(path, surface.normals) : write_png16(path, normals_in_16_bits(surface.normals));
    }
    progress.advance();
  }
  ExportSummary summary;
  summary.num_images = views.views.size();
  return summary;
}

}  // namespace cpplus
