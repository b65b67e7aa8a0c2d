#include "cpplus/refine/edge_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace cpplus {
namespace {

// The edge's ends are clipped by sampling it: at most this many samples an edge, however near it passes.
constexpr int kMaxSamplesPerEdge = 400;

class Sampler {
 public:
  Sampler(const Camera& camera, const Rigid3& camera_from_map, const PlaneBuffer& planes,
          const EdgeSampleOptions& options)
      : camera_(camera),
        camera_from_map_(camera_from_map),
        planes_(planes),
        options_(options),
        center_(camera_center(camera_from_map)) {}

  void sample(const MapEdge& edge, uint32_t index, std::vector<EdgeSample>* samples) const {
    const double distance = distance_to(edge);
    if (distance > options_.max_distance_m) return;
    const Eigen::Vector3d along = edge.end - edge.start;
    const double length = along.norm();
    const double length_px = length / std::max(distance, 0.2) * camera_.pixels_per_radian();
    const int count = std::clamp(static_cast<int>(std::ceil(length_px / options_.spacing_px)), 1, kMaxSamplesPerEdge);

    Eigen::Vector2d last = Eigen::Vector2d::Constant(-1e9);
    for (int k = 0; k < count; ++k) {
      const Eigen::Vector3d x = edge.start + (k + 0.5) / count * along;
      const auto pixel = camera_.project(camera_from_map_ * x);
      if (!pixel || !camera_.in_image(*pixel, 2.0)) continue;
      // Seen end-on or from afar, samples crowd in the image: keep their distance.
      if ((*pixel - last).norm() < 0.6 * options_.spacing_px) continue;
      if (!is_visible(edge, x, *pixel)) continue;
      last = *pixel;
      samples->push_back({x, along / length, index, 0});
    }
  }

 private:
  double distance_to(const MapEdge& edge) const {
    const Eigen::Vector3d along = edge.end - edge.start;
    const double t = std::clamp((center_ - edge.start).dot(along) / std::max(1e-12, along.squaredNorm()), 0.0, 1.0);
    return (edge.start + t * along - center_).norm();
  }

  bool is_visible(const MapEdge& edge, const Eigen::Vector3d& x, const Eigen::Vector2d& pixel) const {
    if (edge.kind == MapEdgeKind::kSilhouette) return true;  // found in what this view sees
    const double range = (x - center_).norm();
    if (!planes_.is_visible(x, pixel, options_.occlusion_margin_m)) return false;
    if (edge.kind != MapEdgeKind::kBoundary) return true;

    return ends_in_view(edge, x, pixel, range);
  }

  // Beyond a true border the camera sees something behind the plane's continuation; beyond the border of a LiDAR shadow
  // it sees whatever cast the shadow, which is nearer, or nothing.
  bool ends_in_view(const MapEdge& edge, const Eigen::Vector3d& x, const Eigen::Vector2d& pixel, double range) const {
    const auto beside = camera_.project(camera_from_map_ * (x - 0.02 * edge.inward_a));
    if (!beside) return false;
    const Eigen::Vector2d step = *beside - pixel;
    if (step.norm() < 1e-9) return false;
    // Far enough for the footprint of the plane's own last points in the depth buffer.
    const double offset =
        std::max(options_.jump_offset_px, options_.jump_offset_m / range * camera_.pixels_per_radian());
    const Eigen::Vector2d outward = offset * step.normalized();
    const double jump = options_.min_jump_m + options_.min_jump_ratio * range;
    return behind_plane(edge, x, pixel + outward) > jump && std::abs(behind_plane(edge, x, pixel - outward)) < jump;
  }

  // How far behind the plane of the edge the map's surface lies at a pixel, along the ray, metres; NaN where there is
  // none.
  double behind_plane(const MapEdge& edge, const Eigen::Vector3d& x, const Eigen::Vector2d& pixel) const {
    const int32_t seen = planes_.plane_at(pixel);
    const auto bearing = seen == PlaneBuffer::kNone ? std::nullopt : camera_.unproject(pixel);
    if (!bearing) return std::numeric_limits<double>::quiet_NaN();
    MapPlane continuation;
    continuation.normal = edge.normal_a;
    continuation.centroid = x;
    return planes_.range_along((*planes_.planes)[static_cast<size_t>(seen)], *bearing) -
           planes_.range_along(continuation, *bearing);
  }

  const Camera& camera_;
  const Rigid3& camera_from_map_;
  const PlaneBuffer& planes_;
  const EdgeSampleOptions& options_;
  Eigen::Vector3d center_;
};

// Whether all cells around show a surface nearer than that; where the raster has none, nothing hides.
bool is_hidden(const RangeRaster& raster, const Eigen::Vector2d& pixel, double nearer_than_m) {
  const Eigen::Vector2i cell = raster.cell_of(pixel.cast<float>());
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const double nearest = static_cast<double>(raster.range_at(cell + Eigen::Vector2i(dx, dy)));
      if (nearest <= 0.0 || nearest > nearer_than_m) return false;
    }
  }
  return true;
}

// Samples are ordered by edge.
void count_samples(std::vector<EdgeSample>* samples) {
  for (size_t begin = 0, end = 0; begin < samples->size(); begin = end) {
    while (end < samples->size() && (*samples)[end].edge == (*samples)[begin].edge) ++end;
    for (size_t i = begin; i < end; ++i) (*samples)[i].edge_samples = static_cast<uint32_t>(end - begin);
  }
}

}  // namespace

void EdgeSampleOptions::validate() const {
  check_option(spacing_px > 0, "spacing_px", "(0, inf)", spacing_px);
  check_option(max_distance_m > 0, "max_distance_m", "(0, inf)", max_distance_m);
  check_option(occlusion_margin_m >= 0, "occlusion_margin_m", "[0, inf)", occlusion_margin_m);
  check_option(surface_margin_m >= 0, "surface_margin_m", "[0, inf)", surface_margin_m);
  check_option(surface_margin_ratio >= 0, "surface_margin_ratio", "[0, inf)", surface_margin_ratio);
  check_option(min_jump_m > 0, "min_jump_m", "(0, inf)", min_jump_m);
  check_option(min_jump_ratio >= 0, "min_jump_ratio", "[0, inf)", min_jump_ratio);
  check_option(jump_offset_px > 0, "jump_offset_px", "(0, inf)", jump_offset_px);
  check_option(jump_offset_m >= 0, "jump_offset_m", "[0, inf)", jump_offset_m);
}

std::vector<EdgeSample> sample_visible_edges(const std::vector<MapEdge>& edges, const Camera& camera,
                                             const Rigid3& camera_from_map, const PlaneBuffer& planes,
                                             const EdgeSampleOptions& options) {
  const Sampler sampler(camera, camera_from_map, planes, options);
  std::vector<EdgeSample> samples;
  for (size_t i = 0; i < edges.size(); ++i) sampler.sample(edges[i], static_cast<uint32_t>(i), &samples);
  count_samples(&samples);
  return samples;
}

void drop_hidden_samples(const RangeRaster& raster, const Camera& camera, const Rigid3& camera_from_map,
                         const EdgeSampleOptions& options, std::vector<EdgeSample>* samples) {
  std::erase_if(*samples, [&](const EdgeSample& sample) {
    const Eigen::Vector3d x_in_camera = camera_from_map * sample.x_in_map;
    const double range = x_in_camera.norm();
    const auto pixel = camera.project(x_in_camera);
    const double margin = std::max(options.surface_margin_m, options.surface_margin_ratio * range);
    return pixel && is_hidden(raster, *pixel, range - margin);
  });
  count_samples(samples);
}

}  // namespace cpplus
