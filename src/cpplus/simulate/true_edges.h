#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/simulate/tracer.h"

namespace cpplus {

/// A straight line where two surfaces of the scene meet and both can be seen from free space.
struct TrueEdge {
  Eigen::Vector3d begin = Eigen::Vector3d::Zero();  // map frame, metres
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_a = Eigen::Vector3d::Zero();  // outward normals of the two surfaces
  Eigen::Vector3d normal_b = Eigen::Vector3d::Zero();
  bool convex = false;    // an outer corner; false = an inner one, as between wall and floor
  uint32_t object_a = 0;  // index in Scene::objects
  uint32_t object_b = 0;
};

struct TrueEdgeOptions {
  /// Smallest angle between the two surfaces, degrees. (0, 90]
  double min_angle_deg = 20.0;
  /// Shorter edges are left out, metres. [0, inf)
  double min_length_m = 0.05;
  /// How far free space must reach from the edge for it to count: edges in narrow slits cannot be seen. [0, inf)
  double min_opening_m = 0.06;
};

/// All edges of the static scene: borders between faces of one solid, and contact lines of different solids (a box on
/// the floor). Collinear pieces are joined. Pairs of faces are found by sweeping their bounding boxes along x.
std::vector<TrueEdge> find_true_edges(const Tracer& tracer, const TrueEdgeOptions& options = {});

}  // namespace cpplus
