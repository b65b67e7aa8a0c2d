#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "cpplus/simulate/scene_draft.h"

namespace cpplus {

/// A rectangular room of the floor plan. Walls run counter-clockwise: 0 south, 1 east, 2 north, 3 west; positions on a
/// wall are metres from its start.
struct Room {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Ones();
  double height_m = 2.8;
  std::array<std::vector<WallOpening>, 4> openings;  // of each wall, ascending

  std::array<Eigen::Vector2d, 2> wall(int side) const;
  double wall_length(int side) const { return side % 2 == 0 ? high.x() - low.x() : high.y() - low.y(); }
  Eigen::Vector2d center() const { return 0.5 * (low + high); }
};

struct FurnishOptions {
  int boards = 0;
  bool rug = true;
  bool table = true;
  /// Share of the wall that gets something. [0, 1]
  double density = 0.9;
  int plants = 1;
};

/// Floor and ceiling slabs over a rectangle.
void add_floor(SceneDraft& draft, const Eigen::Vector2d& low, const Eigen::Vector2d& high, uint32_t material);
void add_ceiling(SceneDraft& draft, const Eigen::Vector2d& low, const Eigen::Vector2d& high, double height_m,
                 uint32_t material);

/// Puts furniture along the walls (never before an opening), a table on a rug in the middle, posters and lamps.
void furnish_room(SceneDraft& draft, const Room& room, const FurnishOptions& options);

/// Square columns or pipes in corners, beams and a pipe under the ceiling.
void add_structure(SceneDraft& draft, const Room& room);

}  // namespace cpplus
