#include "cpplus/simulate/scene.h"

#include "cpplus/core/error.h"
#include "cpplus/simulate/scene_builders.h"

namespace cpplus {

const std::vector<std::string>& scene_names() {
  static const std::vector<std::string> names = {"room", "rooms", "hall", "street", "corridor"};
  return names;
}

Scene build_scene(const std::string& name, uint64_t seed) {
  if (name == "room") return build_room(seed);
  if (name == "rooms") return build_rooms(seed);
  if (name == "hall") return build_hall(seed);
  if (name == "street") return build_street(seed);
  if (name == "corridor") return build_corridor(seed);
  throw UsageError("option scene must be room, rooms, hall, street or corridor, got " + name);
}

}  // namespace cpplus
