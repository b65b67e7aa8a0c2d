#include "cpplus/simulate/district_window.h"

#include <cmath>
#include <utility>
#include <vector>

#include "cpplus/core/memory.h"
#include "cpplus/core/parallel.h"
#include "cpplus/simulate/district_tile.h"

namespace cpplus {

struct DistrictWindow::Tile {
  Tile(Scene built, float light_cell_m)
      : scene(std::move(built)), traced(scene.mesh, scene.materials), light(scene.mesh, light_cell_m) {
    // Embree has its own copy.
    free_memory(&scene.mesh.vertices);
    free_memory(&scene.mesh.triangles);
  }

  Scene scene;
  TracedMesh traced;
  LightCells light;
};

DistrictWindow::DistrictWindow(const DistrictPlan& plan, const Scene& surroundings, double reach_m)
    : plan_(plan),
      reach_m_(reach_m),
      light_cell_m_(surroundings.light_cell_m),
      tracer_(surroundings, Tracer::Parts{}),
      light_(tracer_, light_cell_m_) {}

void DistrictWindow::move_to(const Eigen::Vector2d& place) {
  const DistrictTile middle = plan_.tile_at(place);
  if (middle == middle_) return;
  middle_ = middle;
  std::erase_if(tiles_, [&](const auto& entry) { return plan_.distance_m(middle, entry.first) >= reach_m_; });
  const int steps = static_cast<int>(std::ceil(reach_m_ / plan_.pitch_m)) + 1;
  std::vector<DistrictTile> missing;
  for (int x = middle.x - steps; x <= middle.x + steps; ++x) {
    for (int y = middle.y - steps; y <= middle.y + steps; ++y) {
      const DistrictTile tile = {x, y};
      if (plan_.distance_m(middle, tile) < reach_m_ && !tiles_.contains(tile)) missing.push_back(tile);
    }
  }
  std::vector<std::shared_ptr<Tile>> made(missing.size());
  parallel_for_each(missing.size(), [&](size_t i) {
    made[i] = std::make_shared<Tile>(build_district_tile(plan_, missing[i]), light_cell_m_);
  });
  for (size_t i = 0; i < missing.size(); ++i) tiles_[missing[i]] = made[i];
  Tracer::Parts parts;
  SoftLight::Parts light;
  for (const auto& [index, tile] : tiles_) {
    parts.emplace_back(tile, &tile->traced);
    light.emplace_back(tile, &tile->light);
  }
  tracer_.set_parts(std::move(parts));
  light_.set_parts(std::move(light));
}

}  // namespace cpplus
