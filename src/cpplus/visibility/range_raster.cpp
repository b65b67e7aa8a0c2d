#include "cpplus/visibility/range_raster.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "cpplus/core/vector_clones.h"
#include "cpplus/visibility/range_keys.h"

namespace cpplus {
namespace {

constexpr float kNoSurface = std::numeric_limits<float>::infinity();
// Half edge of the square that a point covers, in spacings: gaps twice as wide are closed. Points at random leave
// hardly any larger ones.
constexpr float kHalfSquareSpacings = 1.0f;
constexpr int kMaxHalfCells = 12;
constexpr size_t kMostUsualPoints = 1 << 20;  // of a view; memory that is not written to costs nothing

int half_cells(float spacing_px, float inverse_cell) {
  const int half = static_cast<int>(kHalfSquareSpacings * spacing_px * inverse_cell + 0.5f);
  return std::clamp(half, 1, kMaxHalfCells);
}

RangeKey key_of(const ProjectedPoint& point) {
  return range_key(point.range, std::bit_cast<uint32_t>(point.spacing_px));
}

// Indices of the points' cells in a raster of that size.
CPPLUS_VECTOR_CLONES void find_cells(const ProjectedPoint* points, size_t count, const RangeRaster& raster, int width,
                                     int height, uint32_t* cells) {
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector2i at = raster.cell_of(points[i].pixel);
    const int x = std::min(std::max(at.x(), 0), width - 1);
    const int y = std::min(std::max(at.y(), 0), height - 1);
    cells[i] = static_cast<uint32_t>(y * width + x);
  }
}

float spacing_of(RangeKey key) { return std::bit_cast<float>(what_of(key)); }

// Half the width in cells of the square of the point that each cell shows, 0 where it shows none.
CPPLUS_VECTOR_CLONES void halves_of(const RangeKey* keys, size_t count, float inverse_cell, uint8_t* half) {
  for (size_t i = 0; i < count; ++i) {
    const int of_key = half_cells(spacing_of(keys[i]), inverse_cell);
    half[i] = static_cast<uint8_t>(keys[i] == kNoRangeKey ? 0 : of_key);
  }
}

Image<uint8_t> halves_of(const Image<RangeKey>& keys, float inverse_cell) {
  Image<uint8_t> half(keys.width, keys.height);
  halves_of(keys.pixels.data(), keys.pixels.size(), inverse_cell, half.pixels.data());
  return half;
}

// Takes the keys of squares of one size where they are nearer.
CPPLUS_VECTOR_CLONES void take_halves(const RangeKey* from, const uint8_t* half, uint8_t which, size_t count,
                                      RangeKey* to) {
  for (size_t i = 0; i < count; ++i) {
    const RangeKey key = half[i] == which ? from[i] : kNoRangeKey;
    to[i] = key < to[i] ? key : to[i];
  }
}

// Spreads each point over its square, the nearest winning. Squares grow by one cell a step, the larger ones from an
// earlier step on; the few very large ones are drawn one by one.
Image<RangeKey> dilate(const Image<RangeKey>& in, float inverse_cell) {
  constexpr uint8_t kMostSteps = 4;
  const Image<uint8_t> half = halves_of(in, inverse_cell);
  Image<RangeKey> large;
  std::array<bool, kMaxHalfCells + 1> occurs{};
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) {
      const int h = half.at(x, y);
      occurs[static_cast<size_t>(h)] = true;
      if (h <= kMostSteps) continue;
      if (large.empty()) large = Image<RangeKey>(in.width, in.height, kNoRangeKey);
      draw_rectangle(std::max(0, x - h), std::min(in.width - 1, x + h), y - h, y + h, in.at(x, y), &large);
    }
  }
  Image<RangeKey> out(in.width, in.height, kNoRangeKey);
  bool any = false;
  for (uint8_t step = kMostSteps; step > 0; --step) {
    any |= occurs[step];
    if (!any) continue;
    take_halves(in.pixels.data(), half.pixels.data(), step, in.pixels.size(), out.pixels.data());
    spread_by_one(&out);
  }
  if (!large.empty()) take_nearer(large, &out);
  return out;
}

// What each cell shows: range (kNoSurface where nothing) and spacing (0).
CPPLUS_VECTOR_CLONES void unpack(const RangeKey* keys, size_t count, float* range, float* spacing_px) {
  for (size_t i = 0; i < count; ++i) {
    range[i] = keys[i] == kNoRangeKey ? kNoSurface : range_of(keys[i]);
    spacing_px[i] = spacing_of(keys[i]);  // of no key 0
  }
}
static_assert(std::bit_cast<uint64_t>(kNoRangeKey) << 32 == 0);

// The largest range within half[x] cells of each cell of a line of cells, kNoSurface where half is 0. neighbor(h) gives
// the lines of cells h before and h after.
template <typename Neighbor>
[[gnu::always_inline]] inline void erode_line(const uint8_t* half, const float* in, int width, const Neighbor& neighbor,
                                              float* largest, float* out) {
  uint8_t widest = 0;
  for (int x = 0; x < width; ++x) widest = widest < half[x] ? half[x] : widest;
  for (int x = 0; x < width; ++x) largest[x] = in[x];
  for (int x = 0; x < width; ++x) out[x] = kNoSurface;
  for (int h = 1; h <= widest; ++h) {
    const auto [before, after] = neighbor(h);
    for (int x = 0; x < width; ++x) {
      const float farther = before[x] < after[x] ? after[x] : before[x];
      largest[x] = largest[x] < farther ? farther : largest[x];
      out[x] = half[x] == h ? largest[x] : out[x];
    }
  }
}

CPPLUS_VECTOR_CLONES void erode_along_row(const uint8_t* half, const float* padded, int width, float* largest,
                                          float* out) {
  erode_line(
      half, padded, width, [&](int h) { return std::pair(padded - h, padded + h); }, largest, out);
}

CPPLUS_VECTOR_CLONES void erode_across_rows(const uint8_t* half, const float* in, int width, int y, int height,
                                            float* largest, float* out) {
  const std::ptrdiff_t stride = width;
  erode_line(
      half, in, width,
      [&](int h) {
        // Beyond the border the row itself, which counts already.
        return std::pair(y - h < 0 ? in : in - h * stride, y + h >= height ? in : in + h * stride);
      },
      largest, out);
  for (int x = 0; x < width; ++x) out[x] = out[x] == kNoSurface ? 0.0f : out[x];
}

// The largest range within the square of the point that each cell shows, one axis after the other; 0 where it shows
// none or the square reaches beyond the surface.
RangeImage erode(const Image<uint8_t>& half, RangeImage range) {
  std::vector<float> padded(static_cast<size_t>(range.width + 2 * kMaxHalfCells), 0.0f);
  std::vector<float> largest(static_cast<size_t>(range.width));
  for (int y = 0; y < range.height; ++y) {
    float* row = &range.at(0, y);
    std::copy_n(row, range.width, padded.begin() + kMaxHalfCells);
    erode_along_row(&half.at(0, y), padded.data() + kMaxHalfCells, range.width, largest.data(), row);
  }
  RangeImage out(range.width, range.height);
  for (int y = 0; y < range.height; ++y) {
    erode_across_rows(&half.at(0, y), &range.at(0, y), range.width, y, range.height, largest.data(), &out.at(0, y));
  }
  return out;
}

}  // namespace

RangeRasterDrawer::RangeRasterDrawer(const Camera& camera, double cell_px)
    : nearest_(static_cast<int>(std::ceil(camera.width() / cell_px)),
               static_cast<int>(std::ceil(camera.height() / cell_px)), kNoRangeKey) {
  raster_.cell_px = cell_px;
}

void RangeRasterDrawer::add(std::span<const ProjectedPoint> points, uint32_t* cells) {
  find_cells(points.data(), points.size(), raster_, nearest_.width, nearest_.height, cells);
  for (size_t i = 0; i < points.size(); ++i) {
    RangeKey& nearest = nearest_.pixels[cells[i]];
    nearest = std::min(nearest, key_of(points[i]));
  }
}

RangeRaster RangeRasterDrawer::finish() && {
  const float inverse_cell = 1.0f / static_cast<float>(raster_.cell_px);
  const Image<RangeKey> keys = dilate(nearest_, inverse_cell);
  RangeImage dilated(keys.width, keys.height);
  raster_.spacing_px = RangeImage(keys.width, keys.height);
  unpack(keys.pixels.data(), keys.pixels.size(), dilated.pixels.data(), raster_.spacing_px.pixels.data());
  raster_.range = erode(halves_of(keys, inverse_cell), std::move(dilated));
  return std::move(raster_);
}

PointsInView points_in_view(const VoxelMap& map, const std::vector<float>& leaf_spacing, const PlaneBuffer& planes,
                            double max_distance_m, double cell_px) {
  PointsInView view;
  view.points.reserve(std::min(map.num_points(), kMostUsualPoints));
  view.cells.reserve(view.points.capacity());
  RangeRasterDrawer drawer(planes.camera, cell_px);
  project_points(map, leaf_spacing, planes, max_distance_m,
                 [&](std::span<const ProjectedPoint> some, std::span<const uint32_t>) {
                   view.points.insert(view.points.end(), some.begin(), some.end());
                   view.cells.resize(view.points.size());
                   drawer.add(some, view.cells.data() + view.cells.size() - some.size());
                 });
  view.raster = std::move(drawer).finish();
  return view;
}

void add_points_by_cell(double noise_m, PointsInView* view) {
  PointsByCell& by_cell = view->raster.points;
  by_cell.noise_m = noise_m;
  by_cell.begin.assign(view->raster.range.pixels.size() + 1, 0);
  for (const uint32_t cell : view->cells) ++by_cell.begin[cell + 1];
  std::partial_sum(by_cell.begin.begin(), by_cell.begin.end(), by_cell.begin.begin());
  by_cell.points.resize(view->points.size());
  std::vector<uint32_t> next(by_cell.begin.begin(), by_cell.begin.end() - 1);
  for (size_t i = 0; i < view->points.size(); ++i) {
    by_cell.points[next[view->cells[i]]++] = {view->points[i].pixel, view->points[i].range};
  }
}

}  // namespace cpplus
