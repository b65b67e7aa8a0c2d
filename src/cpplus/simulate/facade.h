#pragma once

#include "cpplus/simulate/scene_draft.h"

namespace cpplus {

struct FacadeOptions {
  double width_m = 10.0;
  double depth_m = 8.0;
  int floors = 3;
  bool shop = true;  // sign, awning and large panes on the ground floor
};

/// A house whose front stands on y = 0 from x = 0 to width_m and faces +y: piers, sunken windows with bars and sills,
/// door, string courses, cornice. Panes are dark and solid.
void add_house(SceneDraft& draft, const Rigid3& frame, const FacadeOptions& options);

/// Trunk and a ball of leaves.
void add_tree(SceneDraft& draft, const Eigen::Vector3d& position, double height_m);
void add_street_lamp(SceneDraft& draft, const Eigen::Vector3d& position, double yaw_rad);
void add_traffic_sign(SceneDraft& draft, const Eigen::Vector3d& position, double yaw_rad);

}  // namespace cpplus
