#pragma once

#include "cpplus/simulate/district_plan.h"
#include "cpplus/simulate/scene.h"

namespace cpplus {

/// What surrounds all tiles: sky, sun and the way. Without a mesh.
Scene district_surroundings(const DistrictPlan& plan);

/// Mesh and materials of one tile, in the frame of the map. It ends in the middle of the streets around it, where the
/// next tiles begin.
Scene build_district_tile(const DistrictPlan& plan, const DistrictTile& tile);

}  // namespace cpplus
