#include "cpplus/features/patch_surface.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "cpplus/features/seen_points.h"

namespace cpplus {
namespace {

// What is nearer than a surface by less than this may be its own noise, or the width of a cell seen at a slant.
constexpr double kMarginM = 0.08;
constexpr double kMarginRatio = 0.03;
// Of a tangent plane: least share of cells with a surface and number of those with points, least share of the latter on
// the plane, largest deviation of their means from it.
constexpr double kMinFilled = 0.9;
constexpr size_t kMinCells = 12;
constexpr double kMinOnPlane = 0.8;
constexpr double kMaxScatterM = 0.03;
constexpr double kMaxScatterRatio = 0.005;
// Points up to so many deviations of the map's noise behind the nearest belong to its surface, half of that on either
// side once the surface is known; what beams at a slant smear adds a share of the range.
constexpr double kFrontNoises = 6.0;
constexpr double kBandNoises = 3.0;
constexpr double kBandRatio = 0.01;
constexpr int kTangentRounds = 4;
// Most points in front of the surface for each that lies on it: people leave some who walked through the scan.
constexpr double kMaxInFront = 0.3;
// A surface is not better known than the width of a beam lets it.
constexpr double kMinRangeSigmaM = 0.01;
// Of a plane as a whole: the map is distorted by some millimetres.
constexpr double kMapSigmaM = 0.004;
// The points under a patch lie on its plane when their median does not leave it by more than this along the ray: what
// protrudes from a plane or lies behind it is drawn as the plane, too.
constexpr double kOnPlaneM = 0.015;
constexpr double kOnPlaneRatio = 0.003;
// Fewest of them whose median says where the plane is.
constexpr size_t kMinPoints = 12;

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

// n of 1 / range = n . bearing by least squares through the points that are asked for; weights r^4 turn deviations of
// 1 / r into deviations of r.
template <typename IsAsked>
Eigen::Vector3d fit_tangent(const std::vector<SeenPoint>& points, const IsAsked& is_asked) {
  Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  for (const SeenPoint& p : points) {
    if (!is_asked(p)) continue;
    const double weight = p.range * p.range * p.range * p.range;
    h.noalias() += weight * p.bearing * p.bearing.transpose();
    g += weight / p.range * p.bearing;
  }
  return h.ldlt().solve(g);
}

double range_of_tangent(const Eigen::Vector3d& n, const Eigen::Vector3d& bearing) { return 1.0 / n.dot(bearing); }

struct TangentSupport {
  size_t num_cells = 0;    // on the plane: with points on it and few in front
  double share = 0.0;      // of the cells that show something
  double scatter_m = 0.0;  // RMS deviation of the cells' means along the rays
};

TangentSupport support_of(const SeenSquare& square, const Eigen::Vector3d& n, double band_m) {
  struct Cell {
    double sum = 0.0;
    int num_on = 0;
    int num_before = 0;
    bool shows_behind = false;  // what lies behind the plane and is not hidden
  };
  std::vector<Cell> cells(square.num_cells);
  for (const SeenPoint& p : square.points) {
    const double of_plane = range_of_tangent(n, p.bearing);
    const double behind = p.range - of_plane;
    Cell& cell = cells[p.cell];
    cell.num_before += behind < -band_m;
    cell.shows_behind |= behind > band_m && p.nearest > of_plane + band_m;
    if (!(std::abs(behind) <= band_m)) continue;
    cell.sum += behind;
    ++cell.num_on;
  }
  TangentSupport support;
  double squares = 0.0;
  size_t num_off = 0;
  for (const Cell& cell : cells) {
    if (cell.num_on > 0 && cell.num_before <= kMaxInFront * cell.num_on) {
      squares += std::pow(cell.sum / cell.num_on, 2);
      ++support.num_cells;
    } else if (cell.num_before > 0 || cell.shows_behind) {
      ++num_off;
    }
  }
  if (support.num_cells == 0) return support;
  support.share = static_cast<double>(support.num_cells) / static_cast<double>(support.num_cells + num_off);
  support.scatter_m = std::sqrt(squares / static_cast<double>(support.num_cells));
  return support;
}

// The nearest surface, in front of what lies behind. What the raster shows in a cell is the nearest of all points that
// reach there, which a slanted surface has far in front of its own: the fit starts from what lies close behind that and
// then takes what lies on both sides of itself.
std::optional<PatchSurface> tangent_under(const PlaneBuffer& planes, const SeenSquare& square, double noise_m,
                                          const Eigen::Vector2d& pixel) {
  const auto bearing = planes.camera.unproject(pixel);
  if (!bearing || square.share_filled < kMinFilled || square.num_cells < kMinCells) return std::nullopt;
  Eigen::Vector3d n =
      fit_tangent(square.points, [&](const SeenPoint& p) { return p.range <= p.nearest + kFrontNoises * noise_m; });
  const double band_m = kBandNoises * noise_m + kBandRatio * range_of_tangent(n, *bearing);
  for (int round = 0; round < kTangentRounds; ++round) {
    n = fit_tangent(square.points, [&, last = n](const SeenPoint& p) {
      return std::abs(p.range - range_of_tangent(last, p.bearing)) <= band_m;
    });
  }
  const double range = range_of_tangent(n, *bearing);
  if (!(range > 0.0)) return std::nullopt;
  const TangentSupport support = support_of(square, n, band_m);
  if (support.num_cells < kMinCells || support.share < kMinOnPlane) return std::nullopt;
  if (support.scatter_m > kMaxScatterM + kMaxScatterRatio * range) return std::nullopt;

  const Rigid3 map_from_camera = inverse(planes.camera_from_map);
  PatchSurface surface;
  surface.plane.centroid = map_from_camera * Eigen::Vector3d(range * *bearing);
  surface.plane.normal = map_from_camera.rotation * -n.normalized();
  surface.range_sigma_m = std::max(kMinRangeSigmaM, support.scatter_m);
  return surface;
}

// By how much the points in view lie behind a plane along their rays: their median, nothing where that is too much for
// them to be the plane's. Of few points it says little; where there are none, the surface drawn around them must lie on
// the plane, which the pixel's ray meets at range_m.
std::optional<double> distance_behind(const MapPlane& plane, double range_m, const PlaneBuffer& planes,
                                      const SeenSquare& square, const RangeRaster& raster,
                                      const Eigen::Vector2d& pixel) {
  std::vector<double> behind;
  for (const SeenPoint& p : square.points) behind.push_back(p.range - planes.range_along(plane, p.bearing));
  if (behind.empty()) {
    const double nearest = static_cast<double>(raster.range_at(raster.cell_of(pixel.cast<float>())));
    return nearest < range_m + margin_at(range_m) ? std::optional(0.0) : std::nullopt;
  }
  const auto middle = behind.begin() + static_cast<std::ptrdiff_t>(behind.size() / 2);
  std::nth_element(behind.begin(), middle, behind.end());
  if (std::abs(*middle) > kOnPlaneM + kOnPlaneRatio * range_m) return std::nullopt;
  return behind.size() < kMinPoints ? 0.0 : *middle;
}

// The plane where the points in view have it, if these are its own.
std::optional<PatchSurface> plane_under(const PlaneBuffer& planes, int32_t id, const SeenSquare& square,
                                        const RangeRaster& raster, const Eigen::Vector2d& pixel) {
  PatchSurface surface;
  surface.plane_id = id;
  surface.plane = (*planes.planes)[static_cast<size_t>(id)];
  surface.range_sigma_m = kMapSigmaM;
  const double range = planes.range_of(surface.plane, pixel);
  if (!is_seen(raster, pixel, range)) return std::nullopt;
  const auto behind = distance_behind(surface.plane, range, planes, square, raster, pixel);
  const auto bearing = planes.camera.unproject(pixel);
  if (!behind || !bearing) return std::nullopt;
  surface.plane.centroid += *behind * (planes.camera_from_map.rotation.conjugate() * *bearing);
  return surface;
}

}  // namespace

bool is_seen(const RangeRaster& raster, const Eigen::Vector2d& pixel, double range_m) {
  const double nearest = static_cast<double>(raster.range_at(raster.cell_of(pixel.cast<float>())));
  return nearest <= 0.0 || nearest > range_m - margin_at(range_m);
}

std::optional<PatchSurface> surface_under(const PlaneBuffer& planes, const RangeRaster& raster,
                                          const Eigen::Vector2d& pixel, double radius_px) {
  const SeenSquare square = points_around(planes.camera, raster, pixel, radius_px);
  const int32_t id = one_plane(planes, pixel, radius_px);
  if (id != PlaneBuffer::kNone) {
    const auto surface = plane_under(planes, id, square, raster, pixel);
    if (surface) return surface;
  }
  return tangent_under(planes, square, raster.points.noise_m, pixel);
}

}  // namespace cpplus
