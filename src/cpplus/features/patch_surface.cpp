#include "cpplus/features/patch_surface.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace cpplus {
namespace {

// What is nearer than a surface by less than this may be its own noise, or the width of a cell seen at a slant.
constexpr double kMarginM = 0.08;
constexpr double kMarginRatio = 0.03;
// Of a tangent plane: least share of cells with a surface and number of those with points, least share of the latter on
// the plane, largest deviation from it.
constexpr double kMinFilled = 0.9;
constexpr size_t kMinSamples = 12;
constexpr double kMinOnPlane = 0.9;
constexpr double kMaxScatterM = 0.03;
constexpr double kMaxScatterRatio = 0.005;
// A surface is not better known than the width of a beam lets it.
constexpr double kMinRangeSigmaM = 0.01;
// Of a plane as a whole: the map is distorted by some millimetres.
constexpr double kMapSigmaM = 0.004;
// The points under a patch lie on its plane when their mean does not leave it by more than this along the ray: what
// protrudes from a plane or lies behind it is drawn as the plane, too.
constexpr double kOnPlaneM = 0.015;
constexpr double kOnPlaneRatio = 0.003;

double margin_at(double range_m) { return kMarginM + kMarginRatio * range_m; }

// The one plane instance in all cells of a square; kNone where there are several.
int32_t one_plane(const PlaneBuffer& planes, const Eigen::Vector2d& pixel, double radius_px) {
  const int32_t id = planes.plane_at(pixel);
  if (id == PlaneBuffer::kNone) return id;
  for (double y = -radius_px; y <= radius_px; y += planes.cell_px) {
    for (double x = -radius_px; x <= radius_px; x += planes.cell_px) {
      if (planes.plane_at(pixel + Eigen::Vector2d(x, y)) != id) return PlaneBuffer::kNone;
    }
  }
  return id;
}

struct RangeSample {
  Eigen::Vector3d bearing;
  double range = 0.0;
  double num_points = 0.0;
};

// The cells of a square that hold points; none where too few of its cells show a surface.
std::vector<RangeSample> ranges_around(const Camera& camera, const RangeRaster& raster, const Eigen::Vector2d& pixel,
                                       double radius_px) {
  std::vector<RangeSample> samples;
  const Eigen::Vector2f reach = Eigen::Vector2f::Constant(static_cast<float>(radius_px));
  const Eigen::Vector2i first = raster.cell_of(pixel.cast<float>() - reach);
  const Eigen::Vector2i last = raster.cell_of(pixel.cast<float>() + reach);
  int num_cells = 0, num_filled = 0;
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x) {
      ++num_cells;
      num_filled += raster.range_at({x, y}) > 0.0f;
      if (!raster.num_points.contains(x, y) || raster.num_points.at(x, y) == 0) continue;
      const auto bearing = camera.unproject(raster.corner_of({x, y}) + Eigen::Vector2d::Constant(0.5 * raster.cell_px));
      if (!bearing) continue;
      samples.push_back(
          {*bearing, static_cast<double>(raster.mean_range.at(x, y)), static_cast<double>(raster.num_points.at(x, y))});
    }
  }
  if (num_filled < kMinFilled * num_cells) samples.clear();
  return samples;
}

struct TangentFit {
  Eigen::Vector3d n = Eigen::Vector3d::Zero();  // 1 / range = n . bearing
  double scatter_m = 0.0;                       // RMS along the rays
};

// Weights r^2 turn deviations of 1 / r into deviations of r.
TangentFit fit_tangent(const std::vector<RangeSample>& samples) {
  Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  for (const RangeSample& s : samples) {
    const double weight = s.num_points * std::pow(s.range, 4);
    h.noalias() += weight * s.bearing * s.bearing.transpose();
    g += weight / s.range * s.bearing;
  }
  TangentFit fit;
  fit.n = h.ldlt().solve(g);
  double squares = 0.0;
  for (const RangeSample& s : samples) squares += std::pow(s.range - 1.0 / fit.n.dot(s.bearing), 2);
  fit.scatter_m = std::sqrt(squares / static_cast<double>(samples.size()));
  return fit;
}

std::optional<PatchSurface> tangent_under(const PlaneBuffer& planes, std::vector<RangeSample> samples,
                                          const Eigen::Vector2d& pixel) {
  const auto bearing = planes.camera.unproject(pixel);
  if (!bearing) return std::nullopt;
  if (samples.size() < kMinSamples) return std::nullopt;
  TangentFit fit = fit_tangent(samples);
  const size_t num_before = samples.size();
  std::erase_if(samples, [&](const RangeSample& s) {
    return !(std::abs(s.range - 1.0 / fit.n.dot(s.bearing)) <= 3.0 * fit.scatter_m);
  });
  if (static_cast<double>(samples.size()) < kMinOnPlane * static_cast<double>(num_before)) return std::nullopt;
  fit = fit_tangent(samples);
  const double slope = fit.n.dot(*bearing);
  if (!(slope > 0.0)) return std::nullopt;
  const double range = 1.0 / slope;
  if (!(fit.scatter_m <= kMaxScatterM + kMaxScatterRatio * range)) return std::nullopt;

  const Rigid3 map_from_camera = inverse(planes.camera_from_map);
  PatchSurface surface;
  surface.plane.centroid = map_from_camera * Eigen::Vector3d(range * *bearing);
  surface.plane.normal = map_from_camera.rotation * -fit.n.normalized();
  surface.range_sigma_m = std::max(kMinRangeSigmaM, fit.scatter_m);
  return surface;
}

// Whether the points in view lie on the plane, which the pixel's ray meets at that range; where there are none, the
// surface drawn around them must.
bool lies_on(const MapPlane& plane, double range_m, const PlaneBuffer& planes, const std::vector<RangeSample>& samples,
             const RangeRaster& raster, const Eigen::Vector2d& pixel) {
  double sum = 0.0;
  double count = 0.0;
  for (const RangeSample& s : samples) {
    sum += s.num_points * (s.range - planes.range_along(plane, s.bearing));
    count += s.num_points;
  }
  if (count > 0.0) return std::abs(sum / count) <= kOnPlaneM + kOnPlaneRatio * range_m;
  const double nearest = static_cast<double>(raster.range_at(raster.cell_of(pixel.cast<float>())));
  return nearest <= 0.0 || nearest < range_m + margin_at(range_m);
}

}  // namespace

bool is_seen(const RangeRaster& raster, const Eigen::Vector2d& pixel, double range_m) {
  const double nearest = static_cast<double>(raster.range_at(raster.cell_of(pixel.cast<float>())));
  return nearest <= 0.0 || nearest > range_m - margin_at(range_m);
}

std::optional<PatchSurface> surface_under(const PlaneBuffer& planes, const RangeRaster& raster,
                                          const Eigen::Vector2d& pixel, double radius_px) {
  std::vector<RangeSample> samples = ranges_around(planes.camera, raster, pixel, radius_px);
  const int32_t id = one_plane(planes, pixel, radius_px);
  if (id != PlaneBuffer::kNone) {
    PatchSurface surface;
    surface.plane_id = id;
    surface.plane = (*planes.planes)[static_cast<size_t>(id)];
    surface.range_sigma_m = kMapSigmaM;
    const double range = planes.range_of(surface.plane, pixel);
    if (is_seen(raster, pixel, range) && lies_on(surface.plane, range, planes, samples, raster, pixel)) return surface;
  }
  return tangent_under(planes, std::move(samples), pixel);
}

}  // namespace cpplus
