#include <Eigen/Geometry>
#include <cmath>

#include "cpplus/simulate/scene.h"

namespace cpplus {

Rigid3 MovingBody::map_from_body(double time_s) const {
  double total = 0.0;
  for (size_t i = 1; i < path.size(); ++i) total += (path[i] - path[i - 1]).norm();
  double way_made = std::fmod(start_m + speed_mps * time_s, 2.0 * total);
  if (way_made < 0.0) way_made += 2.0 * total;
  const bool returning = way_made > total;
  if (returning) way_made = 2.0 * total - way_made;
  size_t leg = 1;
  while (leg + 1 < path.size() && way_made > (path[leg] - path[leg - 1]).norm()) {
    way_made -= (path[leg] - path[leg - 1]).norm();
    ++leg;
  }
  const Eigen::Vector3d along = (path[leg] - path[leg - 1]).normalized();
  const Eigen::Vector3d heading = returning ? Eigen::Vector3d(-along) : along;
  const Rigid3 map_from_ground = placed_at(path[leg - 1] + way_made * along, std::atan2(heading.y(), heading.x()));
  const double swing = swing_rad * std::sin(2.0 * M_PI * swing_hz * time_s + swing_phase_rad);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(swing, Eigen::Vector3d::UnitY()));
  return map_from_ground * Rigid3(turn, pivot - turn * pivot);
}

}  // namespace cpplus
