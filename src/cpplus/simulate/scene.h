#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "cpplus/geometry/rigid3.h"
#include "cpplus/simulate/material.h"
#include "cpplus/simulate/mesh.h"

namespace cpplus {

/// A rectangular lamp facing down its normal half_u x half_v.
struct AreaLight {
  Eigen::Vector3f center = Eigen::Vector3f::Zero();
  Eigen::Vector3f half_u = Eigen::Vector3f::UnitX();  // metres
  Eigen::Vector3f half_v = Eigen::Vector3f::UnitY();  // metres
  Eigen::Vector3f radiance = Eigen::Vector3f::Ones();
};

struct Sky {
  Eigen::Vector3f sun_direction = Eigen::Vector3f(0.3f, 0.4f, 0.85f);  // unit, towards the sun
  Eigen::Vector3f sun_irradiance = Eigen::Vector3f::Zero();
  Eigen::Vector3f zenith = Eigen::Vector3f(0.25f, 0.45f, 0.9f);  // radiance
  Eigen::Vector3f horizon = Eigen::Vector3f(0.75f, 0.85f, 1.0f);
  Eigen::Vector3f ambient = Eigen::Vector3f::Constant(0.15f);  // light that arrives after many bounces
  float ambient_reach_m = 1.0f;                                // surfaces nearer than about this take it away
  uint32_t seed = 0;
};

/// A rigid body that walks, rolls or swings. Its mesh is in the body frame: x forward, z up, on the ground.
struct MovingBody {
  Mesh mesh;
  std::vector<Eigen::Vector3d> path;  // corners of the way, map frame; walked to and fro at constant speed
  double speed_mps = 1.0;
  double start_m = 0.0;                             // way already made at time 0
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();  // of the swing about the body's y axis, body frame
  double swing_rad = 0.0;
  double swing_hz = 0.0;
  double swing_phase_rad = 0.0;

  Rigid3 map_from_body(double time_s) const;
};

struct SceneCheckerboard {
  std::string name;
  int inner_columns = 8;
  int inner_rows = 5;
  double square_m = 0.09;
  /// Inner corners, map frame, row by row from the top left as seen from the front.
  std::vector<Eigen::Vector3d> corners;
};

/// Where the LiDAR goes: control points of a smooth curve with the heading at each.
struct WayPoint {
  Eigen::Vector2d position;  // map frame, metres
  double yaw_rad = 0.0;      // of the LiDAR's x axis
};

struct Way {
  std::vector<WayPoint> points;
  double speed_mps = 0.9;
  double lidar_height_m = 1.5;
  double bob_m = 0.015;     // amplitude of the up and down of steps
  double sway_rad = 0.015;  // amplitude of pitch and roll
};

/// A world: everything that light and laser can meet, in the map frame (metres, z up).
struct Scene {
  std::string name;
  Mesh mesh;
  std::vector<Material> materials;
  std::vector<std::string> objects;  // names, by MeshFace::object
  std::vector<AreaLight> lights;
  Sky sky;
  std::vector<MovingBody> bodies;
  std::vector<SceneCheckerboard> boards;
  Way way;
  float light_cell_m = 0.06f;  // spacing at which soft light is computed on surfaces
};

/// "room", "rooms", "hall", "street", "corridor": the scenes that are made as a whole.
const std::vector<std::string>& scene_names();

/// Builds a scene; the seed chooses sizes, furniture, colours and the way. Throws UsageError for an unknown name.
Scene build_scene(const std::string& name, uint64_t seed);

}  // namespace cpplus
