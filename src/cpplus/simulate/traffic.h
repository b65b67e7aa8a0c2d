#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/simulate/scene_draft.h"

namespace cpplus {

/// A person of about 1.7 m on the path (corners, map frame, on the ground): trunk and head, and four limbs that swing.
void add_walking_person(SceneDraft& draft, const std::vector<Eigen::Vector3d>& path, double speed_mps, double start_m);

/// A car of 4.3 m that drives the path.
void add_driving_car(SceneDraft& draft, const std::vector<Eigen::Vector3d>& path, double speed_mps, double start_m);

/// The same car, standing, as part of the static mesh; x forward.
void add_parked_car(SceneDraft& draft, const Rigid3& frame);

}  // namespace cpplus
