#include "cpplus/visibility/silhouettes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "cpplus/visibility/range_raster.h"

namespace cpplus {
namespace {

// Points at random end one mean spacing inside the outline; the width of a LiDAR's beam puts some beyond it.
constexpr double kSpacingCorrection = 0.5;
constexpr double kMinStripPx = 4.0;
constexpr size_t kMinBins = 5;
// Few points may lie on a line by chance.
constexpr double kMinScatterPx = 0.3;
constexpr double kMinRangeScatterM = 0.02;

// A straight piece of an outline in the image, before its points are looked at.
struct Piece {
  Eigen::Vector2d start;  // pixels
  Eigen::Vector2d along;  // unit
  Eigen::Vector2d outward;
  double length_px = 0.0;
  double spacing_px = 0.0;
  double inverse_range = 0.0;  // of the near surface at the start, and its change per pixel
  double inverse_range_slope = 0.0;
  uint32_t group = 0;

  double strip_px() const { return std::max(kMinStripPx, 2.0 * spacing_px); }
  double margin_px(double cell_px) const { return cell_px + 0.5 * spacing_px + 1.0; }
  double range_at(double along_px) const { return 1.0 / (inverse_range + along_px * inverse_range_slope); }
};

// Least squares of y = offset + slope x.
struct LineFit {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  void add(double x, double y) { n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y; }
  double slope() const {
    const double det = n * sxx - sx * sx;
    return det > 1e-9 ? (n * sxy - sx * sy) / det : 0.0;
  }
  double offset() const { return (sy - slope() * sx) / n; }
};

double median_of(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

class PieceCutter {
 public:
  PieceCutter(const RangeRaster& raster, const SilhouetteOptions& options) : raster_(raster), options_(options) {}

  std::vector<Piece> run() const {
    std::vector<Piece> pieces;
    uint32_t group = 0;
    for (const std::vector<OutlineStep>& chain : trace_outlines(raster_, options_.jump)) {
      const double tolerance_px = options_.max_scatter_px + 0.5 * raster_.cell_px;
      for (const ChainStretch& stretch : straight_stretches(chain, tolerance_px)) {
        cut(chain, stretch, group++, &pieces);
      }
    }
    return pieces;
  }

 private:
  void cut(const std::vector<OutlineStep>& chain, const ChainStretch& stretch, uint32_t group,
           std::vector<Piece>* pieces) const {
    const Eigen::Vector2d start = chain[stretch.begin].pixel;
    const Eigen::Vector2d whole = chain[stretch.end - 1].pixel - start;
    const double length = whole.norm();
    if (length < options_.min_length_px) return;
    std::vector<double> spacings;
    for (size_t i = stretch.begin; i < stretch.end; ++i) {
      spacings.push_back(raster_.spacing_px.at(chain[i].cell.x(), chain[i].cell.y()));
    }
    const double spacing_px = median_of(&spacings);
    if (spacing_px > options_.max_spacing_px) return;
    const Eigen::Vector2d along = whole / length;
    const int count = static_cast<int>(std::ceil(length / std::max(options_.max_length_px, 10.0 * spacing_px)));
    for (int k = 0; k < count; ++k) {
      Piece piece;
      piece.start = start + k * length / count * along;
      piece.along = along;
      piece.outward = Eigen::Vector2d(along.y(), -along.x());  // the near surface is on the right
      piece.length_px = length / count;
      piece.spacing_px = spacing_px;
      piece.group = group;
      LineFit inverse_range;
      for (size_t i = stretch.begin; i < stretch.end; ++i) {
        const double t = along.dot(chain[i].pixel - piece.start);
        if (t < 0.0 || t > piece.length_px) continue;
        inverse_range.add(t, 1.0 / static_cast<double>(chain[i].range));
      }
      if (inverse_range.n < 2) continue;
      piece.inverse_range = inverse_range.offset();
      piece.inverse_range_slope = inverse_range.slope();
      pieces->push_back(piece);
    }
  }

  const RangeRaster& raster_;
  const SilhouetteOptions& options_;
};

// Indices of the cells whose middle lies in the strip of a piece, row by row.
void add_cells(const RangeRaster& raster, const Piece& piece, std::vector<uint32_t>* cells) {
  const double inside = piece.strip_px() + 2.0 * piece.margin_px(raster.cell_px);
  const double outside = 2.0 * piece.margin_px(raster.cell_px);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  for (const double t : {0.0, piece.length_px}) {
    for (const double v : {-inside, outside}) {
      const Eigen::Vector2d corner = piece.start + t * piece.along + v * piece.outward;
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  const Eigen::Vector2i first = raster.cell_of(low.cast<float>()).cwiseMax(0);
  const Eigen::Vector2i last =
      raster.cell_of(high.cast<float>()).cwiseMin(Eigen::Vector2i(raster.range.width - 1, raster.range.height - 1));
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x) {
      const Eigen::Vector2d d =
          raster.corner_of({x, y}) + Eigen::Vector2d::Constant(0.5 * raster.cell_px) - piece.start;
      const double v = piece.outward.dot(d);
      const double t = piece.along.dot(d);
      if (v < -inside || v > outside || t < -raster.cell_px || t > piece.length_px + raster.cell_px) continue;
      cells->push_back(static_cast<uint32_t>(y * raster.range.width + x));
    }
  }
}

// The projected points in the cells of some pieces, cell by cell.
class PointsNearPieces {
 public:
  PointsNearPieces(const PointsInView& view, const std::vector<Piece>& pieces)
      : slot_(view.raster.range.pixels.size(), kNoSlot) {
    for (const Piece& piece : pieces) {
      pieces_begin_.push_back(cells_.size());
      add_cells(view.raster, piece, &cells_);
    }
    pieces_begin_.push_back(cells_.size());
    int32_t num_slots = 0;
    for (const uint32_t cell : cells_) {
      if (slot_[cell] == kNoSlot) slot_[cell] = num_slots++;
    }
    sort(view, static_cast<size_t>(num_slots));
  }

  // Of the k-th piece.
  template <typename Visit>
  void for_each_near(size_t k, const Visit& visit) const {
    for (size_t c = pieces_begin_[k]; c < pieces_begin_[k + 1]; ++c) {
      const auto slot = static_cast<size_t>(slot_[cells_[c]]);
      for (size_t i = first_[slot]; i < first_[slot + 1]; ++i) visit(sorted_[i]);
    }
  }

 private:
  static constexpr int32_t kNoSlot = -1;

  void sort(const PointsInView& view, size_t num_slots) {
    struct Kept {
      uint32_t slot;
      uint32_t point;
    };
    std::vector<Kept> kept;
    first_.assign(num_slots + 1, 0);
    if (num_slots == 0) return;
    for (size_t i = 0; i < view.cells.size(); ++i) {
      const int32_t slot = slot_[view.cells[i]];
      if (slot == kNoSlot) continue;
      kept.push_back({static_cast<uint32_t>(slot), static_cast<uint32_t>(i)});
      ++first_[kept.back().slot];
    }
    uint32_t end = 0;
    for (uint32_t& first : first_) first = end += first;
    sorted_.resize(kept.size());
    for (size_t i = kept.size(); i-- > 0;) sorted_[--first_[kept[i].slot]] = view.points[kept[i].point];
  }

  std::vector<uint32_t> cells_;       // of all pieces
  std::vector<size_t> pieces_begin_;  // in cells_
  std::vector<int32_t> slot_;         // of each cell near a piece
  std::vector<uint32_t> first_;       // of a slot's points
  std::vector<ProjectedPoint> sorted_;
};

// A point of the near surface.
struct SurfacePoint {
  double v;  // outward, pixels
  double t;  // along, pixels
  double range;
  uint32_t bin;
};

// An outermost point of the near surface.
struct BinPoint {
  double v;
  double t;
  double range;
};

struct FittedOutline {
  double offset_px = 0.0;  // outward, at the start of the piece
  double slope = 0.0;
  double sigma_px = 0.0;
  double inverse_range = 0.0;
  double inverse_range_slope = 0.0;
  double range_sigma_m = 0.0;

  double residual_px(const BinPoint& s) const { return s.v - offset_px - slope * s.t; }
  double residual_m(const BinPoint& s) const { return s.range - 1.0 / (inverse_range + inverse_range_slope * s.t); }
};

// The outermost points of the near surface along a piece, one a bin, and the line through them.
class OutlineFit {
 public:
  explicit OutlineFit(const SilhouetteOptions& options) : options_(options) {}

  std::optional<FittedOutline> run(const std::vector<Piece>& pieces, size_t k, const PointsNearPieces& points) {
    collect(pieces[k], k, points);
    const double margin = pieces[k].margin_px(options_.cell_px);
    const double strip = pieces[k].strip_px();
    find_outermost(strip);
    outermost_.clear();
    gaps_.clear();
    for (const Bin& bin : bins_) {
      if (!bin.outermost || bin.outermost->v < -margin || bin.count < 2) continue;
      const double gap = strip / static_cast<double>(bin.count);
      gaps_.push_back(gap);
      outermost_.push_back({bin.outermost->v + kSpacingCorrection * gap, bin.outermost->t, bin.outermost->range});
    }
    if (outermost_.size() < kMinBins || outermost_.size() * 4 < bins_.size() * 3) return std::nullopt;
    return fit(outermost_, median_of(&gaps_));
  }

 private:
  struct Bin {
    const SurfacePoint* outermost = nullptr;
    size_t count = 0;  // points in the strip inside of it
  };

  // The points of the near surface, and how many bins they fall into.
  void collect(const Piece& piece, size_t k, const PointsNearPieces& points) {
    const double wanted_bin_px = std::max(3.0, 0.6 * piece.spacing_px);
    const size_t num_bins = static_cast<size_t>(std::max(1.0, std::round(piece.length_px / wanted_bin_px)));
    const double bin_px = piece.length_px / static_cast<double>(num_bins);
    bins_.assign(num_bins, {});
    surface_.clear();
    const double strip = piece.strip_px();
    const double margin = piece.margin_px(options_.cell_px);
    points.for_each_near(k, [&](const ProjectedPoint& point) {
      const Eigen::Vector2d d = point.pixel.cast<double>() - piece.start;
      const double t = piece.along.dot(d);
      const double v = piece.outward.dot(d);
      if (t < 0.0 || t >= piece.length_px || v > margin || v < -strip - margin) return;
      const double range = static_cast<double>(point.range);
      const double near = piece.range_at(t);
      if (std::abs(range - near) > 0.5 * options_.jump.jump_at(near)) return;
      const size_t bin = std::min(num_bins - 1, static_cast<size_t>(t / bin_px));
      surface_.push_back({v, t, range, static_cast<uint32_t>(bin)});
    });
  }

  void find_outermost(double strip) {
    for (const SurfacePoint& point : surface_) {
      Bin& bin = bins_[point.bin];
      if (!bin.outermost || point.v > bin.outermost->v) bin.outermost = &point;
    }
    for (const SurfacePoint& point : surface_) {
      Bin& bin = bins_[point.bin];
      bin.count += point.v > bin.outermost->v - strip;
    }
  }

  // Three times, from the second on without what is off by more than two deviations.
  std::optional<FittedOutline> fit(const std::vector<BinPoint>& samples, double gap_px) const {
    FittedOutline fitted;
    double sigma = std::numeric_limits<double>::infinity();
    double num_used = 0.0;
    for (int round = 0; round < 3; ++round) {
      std::vector<BinPoint> used;
      LineFit across;
      LineFit inverse_range;
      for (const BinPoint& s : samples) {
        if (std::abs(fitted.residual_px(s)) > 2.0 * sigma) continue;
        used.push_back(s);
        across.add(s.t, s.v);
        inverse_range.add(s.t, 1.0 / s.range);
      }
      if (used.size() < kMinBins || used.size() * 4 < samples.size() * 3) return std::nullopt;
      fitted.offset_px = across.offset();
      fitted.slope = across.slope();
      fitted.inverse_range = inverse_range.offset();
      fitted.inverse_range_slope = inverse_range.slope();
      num_used = static_cast<double>(used.size());
      double squares = 0.0;
      for (const BinPoint& s : used) squares += fitted.residual_px(s) * fitted.residual_px(s);
      sigma = std::max(kMinScatterPx, std::sqrt(squares / num_used));
    }
    double range_squares = 0.0;
    for (const BinPoint& s : samples) range_squares += fitted.residual_m(s) * fitted.residual_m(s);
    fitted.range_sigma_m = std::max(kMinRangeScatterM, std::sqrt(range_squares / static_cast<double>(samples.size())));
    if (sigma > options_.max_scatter_px || fitted.range_sigma_m > options_.max_range_scatter_m) return std::nullopt;
    fitted.sigma_px = std::hypot(sigma / std::sqrt(num_used), 0.3 * gap_px);
    return fitted;
  }

  const SilhouetteOptions& options_;
  std::vector<SurfacePoint> surface_;
  std::vector<Bin> bins_;
  std::vector<BinPoint> outermost_;
  std::vector<double> gaps_;
};

std::optional<MapEdge> lift(const Piece& piece, const FittedOutline& outline, const Camera& camera,
                            const Rigid3& camera_from_map, const SilhouetteOptions& options) {
  const Rigid3 map_from_camera = inverse(camera_from_map);
  const auto point_at = [&](double t) -> std::optional<Eigen::Vector3d> {
    const Eigen::Vector2d pixel =
        piece.start + t * piece.along + (outline.offset_px + outline.slope * t) * piece.outward;
    const auto bearing = camera.unproject(pixel);
    if (!bearing) return std::nullopt;
    return map_from_camera * (*bearing / (outline.inverse_range + outline.inverse_range_slope * t));
  };
  const auto start = point_at(0.0);
  const auto end = point_at(piece.length_px);
  if (!start || !end) return std::nullopt;
  MapEdge edge;
  edge.kind = MapEdgeKind::kSilhouette;
  edge.start = *start;
  edge.end = *end;
  edge.group = piece.group;
  const Eigen::Vector3d ray = 0.5 * (*start + *end) - map_from_camera.translation;
  const double range = ray.norm();
  const Eigen::Vector3d direction = edge.direction();
  edge.inward_a = ray.cross(direction).normalized();  // the near surface is on the right
  edge.normal_a = edge.inward_a.cross(direction).normalized();
  const double sigma_m = std::hypot(outline.sigma_px * range / camera.pixels_per_radian(), options.sigma_m);
  edge.covariance = sigma_m * sigma_m * edge.inward_a * edge.inward_a.transpose() +
                    outline.range_sigma_m * outline.range_sigma_m * edge.normal_a * edge.normal_a.transpose();
  return edge;
}

}  // namespace

void SilhouetteOptions::validate() const {
  check_option(max_distance_m > 0, "max_distance_m", "(0, inf)", max_distance_m);
  check_option(cell_px >= 1, "cell_px", "[1, inf)", cell_px);
  jump.validate();
  check_option(min_length_px > 0, "min_length_px", "(0, inf)", min_length_px);
  check_option(max_length_px > 0, "max_length_px", "(0, inf)", max_length_px);
  check_option(max_spacing_px > 0, "max_spacing_px", "(0, inf)", max_spacing_px);
  check_option(max_scatter_px > 0, "max_scatter_px", "(0, inf)", max_scatter_px);
  check_option(max_range_scatter_m > 0, "max_range_scatter_m", "(0, inf)", max_range_scatter_m);
  check_option(sigma_m > 0, "sigma_m", "(0, inf)", sigma_m);
}

std::vector<MapEdge> find_silhouettes(const VoxelMap& map, const std::vector<float>& leaf_spacing,
                                      const PlaneBuffer& planes, const SilhouetteOptions& options) {
  if (!options.enabled) return {};
  const PointsInView view = points_in_view(map, leaf_spacing, planes, options.max_distance_m, options.cell_px);
  return find_silhouettes(view, planes.camera, planes.camera_from_map, options);
}

std::vector<MapEdge> find_silhouettes(const PointsInView& view, const Camera& camera, const Rigid3& camera_from_map,
                                      const SilhouetteOptions& options) {
  std::vector<MapEdge> edges;
  if (!options.enabled) return edges;
  const std::vector<Piece> pieces = PieceCutter(view.raster, options).run();
  const PointsNearPieces near_points(view, pieces);
  OutlineFit fit(options);
  for (size_t k = 0; k < pieces.size(); ++k) {
    const auto fitted = fit.run(pieces, k, near_points);
    if (!fitted) continue;
    const auto edge = lift(pieces[k], *fitted, camera, camera_from_map, options);
    if (edge) edges.push_back(*edge);
  }
  return edges;
}

}  // namespace cpplus
