#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/core/options.h"
#include "cpplus/visibility/range_raster.h"

namespace cpplus {

struct RangeJumpOptions {
  /// Beyond an outline the map lies at least this much farther than the near surface goes on, metres and share of the
  /// range. (0, inf), [0, inf)
  double min_jump_m = 0.15;
  double min_jump_ratio = 0.02;
  /// Widest stretch without any surface between the near and the far one, pixels. [0, inf)
  double max_empty_px = 40.0;
  /// So far beyond an outline nothing as near as its surface is met, pixels: where the same surface goes on, its points
  /// have a gap; where something nearer stands, it casts the LiDAR shadow that the surface ends in. (0, inf)
  double min_far_px = 16.0;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("min_jump_m", min_jump_m, "Beyond an outline the map lies this much farther, metres.");
    visitor("min_jump_ratio", min_jump_ratio, "The same as a share of the range; both are added.");
    visitor("max_empty_px", max_empty_px, "Widest stretch without surface between near and far, pixels.");
    visitor("min_far_px", min_far_px, "So far beyond an outline nothing as near as its surface is met, pixels.");
  }
  double jump_at(double range) const { return min_jump_m + min_jump_ratio * range; }
};

/// A step of an outline: the border between a cell of a near surface and one where the map lies clearly farther.
struct OutlineStep {
  Eigen::Vector2i cell;   // the near one
  int side = 0;           // of the cell that it is on: 0 right, 1 below, 2 left, 3 above
  Eigen::Vector2d pixel;  // its middle
  float range = 0.0f;     // of the near surface, metres
};

/// Chains of steps, each the next one's neighbour at about the same range, with the near surface on the right-hand side
/// as one follows them in the image (x right, y down). A step belongs to one chain.
///
/// A step is where the far surface lies a jump behind the near one, behind the near one's continuation, and the near
/// one before the far one's: a floor at a grazing angle has ranges that differ by metres from cell to cell, yet no
/// outline. Gaps in a surface and the borders of LiDAR shadows are no outlines (min_far_px).
std::vector<std::vector<OutlineStep>> trace_outlines(const RangeRaster& raster, const RangeJumpOptions& options);

/// A straight stretch of a chain: steps [begin, end).
struct ChainStretch {
  size_t begin = 0;
  size_t end = 0;
};

/// Cuts a chain where it bends: every stretch lies within tolerance_px of the line through its ends (Douglas & Peucker
/// 1973).
std::vector<ChainStretch> straight_stretches(const std::vector<OutlineStep>& chain, double tolerance_px);

}  // namespace cpplus
