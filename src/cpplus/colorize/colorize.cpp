#include "cpplus/colorize/colorize.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "cpplus/cloud/node_range.h"
#include "cpplus/cloud/select_roots.h"
#include "cpplus/colorize/cell_bearings.h"
#include "cpplus/colorize/robust_color.h"
#include "cpplus/colorize/surface_normals.h"
#include "cpplus/core/error.h"
#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"
#include "cpplus/geometry/tangent_box.h"

namespace cpplus {
namespace {

/// Offers a view to the points of one root. Samples are kept by map order, so that roots touch disjoint runs.
void add_view_to_root(const VoxelMap& map, const SurfaceNormals& normals, uint32_t root, const Rigid3& camera_from_map,
                      const TangentBox& box, const ViewSampler& sampler, uint16_t image, ColorSamples* samples) {
  const Eigen::Matrix3d rotation = camera_from_map.rotation.toRotationMatrix();
  const NodeRange nodes = descendants_of(map, 0, root, normals.layer);
  const auto node_diagonal_m = static_cast<float>(std::sqrt(3.0) * map.voxel_size(normals.layer));
  for (uint32_t node = nodes.begin; node < nodes.end; ++node) {
    const Eigen::Vector3d normal_in_camera = rotation * normals.of_node[node].cast<double>();
    const size_t points_begin = map.points_begin(normals.layer, node);
    const size_t points_end = map.points_end(normals.layer, node);
    const Eigen::Vector3d first_in_camera = rotation * map.point(points_begin) + camera_from_map.translation;
    if (box.excludes(first_in_camera.cast<float>(), node_diagonal_m)) continue;
    for (size_t i = points_begin; i < points_end; ++i) {
      const Eigen::Vector3d x_in_camera = rotation * map.point(i) + camera_from_map.translation;
      if (const auto sample = sampler.sample(x_in_camera, normal_in_camera)) {
        samples->add(i, {sample->color, share_in_8_bits(sample->weight, 1), image, share_in_8_bits(sample->radius, 0)});
      }
    }
  }
}

void add_view(const VoxelMap& map, const SurfaceNormals& normals, const ColorView& view,
              const std::vector<Eigen::Vector3f>& bearings, const ViewSamplingOptions& options, ColorSamples* samples) {
  const ViewSampler sampler(view, bearings, options);
  const TangentBox box = tangent_box(view.camera);
  const std::vector<uint32_t> roots = select_roots(map, view.camera, view.camera_from_map, options.max_distance_m);
  parallel_for_each(roots.size(), [&](size_t k) {
    add_view_to_root(map, normals, roots[k], view.camera_from_map, box, sampler, view.index, samples);
  });
}

std::vector<Rgb> gray_of_points(const PointCloud& cloud, const GrayScale& grays) {
  std::vector<Rgb> colors(cloud.size(), grays.gray());
  for (size_t i = 0; i < cloud.intensities.size(); ++i) colors[i] = grays.gray(cloud.intensities[i]);
  return colors;
}

}  // namespace

void ColorizeOptions::validate() const {
  sampling.validate();
  check_option(max_samples >= 1 && max_samples <= 64, "max_samples", "[1, 64]", max_samples);
  check_option(max_deviation >= 0 && max_deviation <= 255, "max_deviation", "[0, 255]", max_deviation);
  check_option(normal_voxel_m > 0, "normal_voxel_m", "(0, inf)", normal_voxel_m);
}

uint16_t color_view_index(size_t index, const std::string& name) {
  if (index > std::numeric_limits<uint16_t>::max()) {
    throw Error(fmt::format("image {}: colours can come from 65536 images at most", name));
  }
  return static_cast<uint16_t>(index);
}

ColorSamples collect_color_samples(const VoxelMap& map, const NextColorView& next_view,
                                   const ColorizeOptions& options) {
  const SurfaceNormals normals = estimate_surface_normals(map, options.normal_voxel_m);
  ColorSamples samples(map.num_points(), options.max_samples);
  CellBearings bearings;
  std::optional<ColorView> view = next_view();
  while (view) {
    // One thread reads the next view (its image is decoded and its depth drawn) while others look at this one.
    std::optional<ColorView> following;
    parallel_for_each(2, [&](size_t task) {
      if (task == 0) {
        following = next_view();
      } else {
        add_view(map, normals, *view, bearings.of(view->depth), options.sampling, &samples);
      }
    });
    view = std::move(following);
  }
  return samples;
}

ExposureCorrection equalize_exposure(const ExposureObservations& observations, const ExposureOptions& options,
                                     ColorizeResult* result) {
  std::map<uint32_t, uint32_t> index_of_camera;
  std::vector<uint32_t> camera_of_image;
  for (const ColorizedImage& image : result->images) {
    const auto next = static_cast<uint32_t>(index_of_camera.size());
    camera_of_image.push_back(index_of_camera.emplace(image.camera_id, next).first->second);
  }
  const ExposureModel model = estimate_exposure(observations, camera_of_image, index_of_camera.size(), options);
  for (size_t i = 0; i < result->images.size(); ++i) result->images[i].exposure = model.images[i];
  for (const auto& [id, index] : index_of_camera) result->vignetting[id] = model.cameras[index];
  result->exposure_residual = model.residual;
  return {model, camera_of_image};
}

std::vector<ColoredPoint> color_points(const ColorSamples& samples, const ExposureCorrection& correction,
                                       const std::vector<ColorizedImage>& images, double max_deviation) {
  std::vector<ColoredPoint> points(samples.num_points());
  parallel_for_chunks(points.size(), 4096, [&](size_t begin, size_t end) {
    std::vector<WeightedColor> colors;
    for (size_t i = begin; i < end; ++i) {
      const std::span<const ColorSample> kept = samples.of_point(i);
      if (kept.empty()) continue;
      colors.clear();
      for (const ColorSample& sample : kept) colors.push_back(correction.corrected(sample));
      const RobustColor robust = robust_color(colors, max_deviation);
      points[i] = {robust.color, robust.spread, samples.num_views(i), images[kept[robust.best].image].image_id};
    }
  });
  return points;
}

ColorizeResult colorize(PointCloud cloud, const VoxelMap& map, const NextColorView& next_view,
                        const ColorizeOptions& options) {
  options.validate();
  ColorizeResult result;
  const auto numbered_view = [&] {
    std::optional<ColorView> view = next_view();
    if (view) {
      view->index = color_view_index(result.images.size(), view->name);
      result.images.push_back({view->name, view->image_id, view->camera_id, {}});
    }
    return view;
  };
  const ColorSamples samples = collect_color_samples(map, numbered_view, options);
  const ExposureCorrection correction =
      equalize_exposure(collect_exposure_observations(samples, result.images.size()), options.exposure, &result);
  cloud.colors = gray_of_points(cloud, GrayScale(cloud.intensities));
  cloud.num_views.assign(cloud.size(), 0);
  cloud.best_images.assign(cloud.size(), 0);
  cloud.color_spreads.assign(cloud.size(), 0);
  const std::vector<ColoredPoint> colored = color_points(samples, correction, result.images, options.max_deviation);
  for (size_t i = 0; i < colored.size(); ++i) {
    if (colored[i].num_views == 0) continue;
    const uint32_t point = map.input_index(i);
    cloud.colors[point] = colored[i].color;
    cloud.num_views[point] = colored[i].num_views;
    cloud.best_images[point] = colored[i].best_image;
    cloud.color_spreads[point] = colored[i].spread;
    ++result.num_colored;
  }
  result.cloud = std::move(cloud);
  return result;
}

}  // namespace cpplus
