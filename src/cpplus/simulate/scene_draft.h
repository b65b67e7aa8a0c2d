#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <string>
#include <vector>

#include "cpplus/core/random.h"
#include "cpplus/simulate/mesh.h"
#include "cpplus/simulate/scene.h"

namespace cpplus {

/// A scene under construction: palette, random choices and the builder of its static mesh.
class SceneDraft {
 public:
  SceneDraft(const std::string& name, uint64_t seed);

  Scene scene;
  Random random;
  MeshBuilder builder;

  uint32_t material(Pattern pattern, const Eigen::Vector3f& color, const Eigen::Vector3f& color2 = {0.2f, 0.2f, 0.2f},
                    float scale_m = 0.3f);
  Material& edit_material(uint32_t index) { return scene.materials[index]; }
  /// Begins a new object; what the builder adds from now on belongs to it. `frame` is map_from_local.
  void begin(const std::string& object_name, const Rigid3& frame = {});

  bool chance(double probability) { return random.uniform() < probability; }
  double pick(double low, double high) { return random.uniform(low, high); }
  Eigen::Vector3f pick_color(float low, float high);
  /// A colour close to grey.
  Eigen::Vector3f pick_muted(float low, float high);
  /// A muted paint for walls.
  Eigen::Vector3f pick_paint();
  Eigen::Vector3f pick_of(std::initializer_list<Eigen::Vector3f> colors);
};

/// A rectangular hole in a wall: along the wall and in height, metres from the wall's start and the floor.
struct WallOpening {
  double begin_m = 0.0;
  double end_m = 1.0;
  double low_m = 0.0;
  double high_m = 2.05;
};

struct WallStyle {
  double height_m = 2.8;
  double thickness_m = 0.15;
  double skirting_m = 0.08;  // height of the skirting board on the left side; 0 = none
  bool skirting_right = false;
  uint32_t material = 0;
  uint32_t trim = 0;  // skirting
};

/// A wall from a to b (floor plan), its left face on the line, its body to the right.
void add_wall(SceneDraft& draft, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
              const std::vector<WallOpening>& openings, const WallStyle& style);

/// Frame whose x axis runs from a to b, y to the left (into the room), origin at a, on the floor.
Rigid3 wall_frame(const Eigen::Vector2d& a, const Eigen::Vector2d& b);

/// Frame, and (when open_rad is not NaN) a leaf hinged at the opening's begin, turned by open_rad to the left side.
void add_door(SceneDraft& draft, const Rigid3& wall, const WallOpening& opening, double thickness_m, double open_rad);
/// Frame bars with a cross, and a sill, in a hole of the wall. No pane: laser and light go through.
void add_window(SceneDraft& draft, const Rigid3& wall, const WallOpening& opening, double thickness_m);
/// A lamp panel under a ceiling at `position` (its lower face), length along the local x axis of yaw.
void add_ceiling_lamp(SceneDraft& draft, const Eigen::Vector3d& position, double yaw_rad, double length_m,
                      double width_m, float radiance);

}  // namespace cpplus
