#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cpplus {

/// The generalised hidden point removal operator with the mirror kernel (Katz, Tal & Basri 2007; Katz & Tal 2015; Eq.
/// 2-3 of Cui & Schwertfeger 2022): each point is flipped over a sphere of radius R around the viewpoint,
///
///   F(p) = p + 2 (R - |p|) p / |p|,     R = radius_factor * max |p|,
///
/// and counts as visible when F(p) is a vertex of the convex hull of all F(p) and the viewpoint.
///
/// points: relative to the viewpoint, metres; one at the viewpoint itself is dropped. radius_factor >= 0.5, the paper's
/// smallest kernel (phi = 2 R = max |p|); the larger, the more points are visible, those behind gaps between samples
/// too. Returns the indices of the visible points, ascending. All of them where no hull exists: fewer than four points,
/// or all in one plane through the viewpoint. Throws Error for a smaller radius_factor or a point that is not finite.
/// O(n log n).
std::vector<uint32_t> remove_hidden_points(const std::vector<Eigen::Vector3d>& points, double radius_factor);

}  // namespace cpplus
