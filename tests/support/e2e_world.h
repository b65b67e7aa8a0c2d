#pragma once

#include <string>

#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// A file of the world that the test e2e/simulate made.
std::string world_path(const std::string& name);

/// The true extrinsic of a simulated world.
Rigid3 world_lidar_from_camera(const std::string& world = world_path(""));

/// Writes a rig with the world's camera at this place; returns `file`.
std::string write_world_rig(const std::string& file, const Rigid3& camera_from_lidar,
                            const std::string& world = world_path(""));

}  // namespace cpplus
