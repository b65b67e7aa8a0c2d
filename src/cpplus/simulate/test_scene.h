#pragma once

#include "cpplus/simulate/scene.h"

namespace cpplus {

/// A wall that fills the plane x = 3 (its front towards the origin) with a lamp-bright square of 1 m in front of it
/// at x = 2, y and z in [-0.5, 0.5]. A LiDAR at the origin looks along +x and never moves.
inline Scene wall_and_square() {
  Scene scene;
  scene.name = "wall";
  Material wall;
  wall.emission = 0.2f;
  wall.color = Eigen::Vector3f::Ones();
  Material square = wall;
  square.emission = 0.5f;
  scene.materials = {wall, square};
  scene.objects = {"wall", "square"};
  MeshBuilder builder(&scene.mesh);
  builder.add_quad({3.0, 20.0, -20.0}, {0.0, -40.0, 0.0}, {0.0, 0.0, 40.0}, 0);
  builder.set_object(1);
  builder.add_quad({2.0, 0.5, -0.5}, {0.0, -1.0, 0.0}, {0.0, 0.0, 1.0}, 1);
  scene.way.points.assign(4, WayPoint{});
  scene.way.lidar_height_m = 0.0;
  scene.way.bob_m = 0.0;
  scene.way.sway_rad = 0.0;
  return scene;
}

/// lidar_from_camera of a camera at the LiDAR's origin that looks along its x axis.
inline Rigid3 camera_ahead() {
  Eigen::Matrix3d rotation;
  rotation << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Rigid3(rotation, Eigen::Vector3d::Zero());
}

}  // namespace cpplus
