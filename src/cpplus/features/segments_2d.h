#pragma once

#include <Eigen/Core>
#include <vector>

namespace cpplus {

/// A point on the border of something in a plane, with the unit normal of the border.
struct DirectedPoint2d {
  Eigen::Vector2d position;  // metres
  Eigen::Vector2d normal;
};

struct Segment2d {
  Eigen::Vector2d start;  // metres
  Eigen::Vector2d end;
  Eigen::Vector2d normal;  // unit, on the same side as those of its points
};

struct Segment2dOptions {
  double tolerance_m = 0.02;  // distance of a point from its segment
  double max_gap_m = 0.2;     // between neighbouring points of a segment
  double min_length_m = 0.25;
  double min_normal_cos = 0.8;  // between a point's normal and its segment's
};

/// Straight segments through directed points: from each free point a line is fitted to its neighbours of the same
/// direction and grown along itself. Deterministic; a point belongs to one segment at most.
std::vector<Segment2d> find_segments(const std::vector<DirectedPoint2d>& points, const Segment2dOptions& options);

}  // namespace cpplus
