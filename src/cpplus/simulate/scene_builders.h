#pragma once

#include <cstdint>

#include "cpplus/simulate/scene.h"

namespace cpplus {

/// The named scenes of build_scene().
Scene build_room(uint64_t seed);
Scene build_rooms(uint64_t seed);
Scene build_hall(uint64_t seed);
Scene build_street(uint64_t seed);
Scene build_corridor(uint64_t seed);

}  // namespace cpplus
