#include "cpplus/colorize/cell_bearings.h"

#include <algorithm>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

/// More than a rig has; images of its cameras may take turns.
constexpr size_t kMaxGrids = 8;

std::vector<Eigen::Vector3f> bearings_of(const DepthBuffer& buffer) {
  const auto width = static_cast<size_t>(buffer.range.width);
  std::vector<Eigen::Vector3f> bearings(buffer.range.pixels.size(), Eigen::Vector3f::Zero());
  parallel_for_chunks(static_cast<size_t>(buffer.range.height), 16, [&](size_t begin, size_t end) {
    for (size_t i = begin * width; i < end * width; ++i) {
      const Eigen::Vector2i cell(static_cast<int>(i % width), static_cast<int>(i / width));
      if (const auto bearing = buffer.camera.unproject(buffer.center_of(cell))) bearings[i] = bearing->cast<float>();
    }
  });
  return bearings;
}

}  // namespace

bool CellBearings::Grid::has_cells_of(const DepthBuffer& buffer) const {
  const Camera &mine = empty.camera, &other = buffer.camera;
  return width == buffer.range.width && height == buffer.range.height && empty.cell_px == buffer.cell_px &&
         empty.margin_cells == buffer.margin_cells && mine.model() == other.model() && mine.width() == other.width() &&
         mine.height() == other.height() && mine.params() == other.params();
}

const std::vector<Eigen::Vector3f>& CellBearings::of(const DepthBuffer& buffer) {
  const auto found =
      std::find_if(grids_.begin(), grids_.end(), [&](const Grid& grid) { return grid.has_cells_of(buffer); });
  if (found != grids_.end()) {
    grids_.splice(grids_.begin(), grids_, found);
    return grids_.front().bearings;
  }
  Grid grid;
  grid.empty.camera = buffer.camera;
  grid.empty.cell_px = buffer.cell_px;
  grid.empty.margin_cells = buffer.margin_cells;
  grid.width = buffer.range.width;
  grid.height = buffer.range.height;
  grid.bearings = bearings_of(buffer);
  grids_.push_front(std::move(grid));
  if (grids_.size() > kMaxGrids) grids_.pop_back();
  return grids_.front().bearings;
}

}  // namespace cpplus
