#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>

#include "cpplus/simulate/district_plan.h"
#include "cpplus/simulate/lighting.h"
#include "cpplus/simulate/tracer.h"

namespace cpplus {

/// The tiles of a district around a place: made when the place comes near, gone when it has moved on.
class DistrictWindow {
 public:
  /// All that is nearer than `reach_m` is there. `surroundings`: of the district; must outlive the window.
  DistrictWindow(const DistrictPlan& plan, const Scene& surroundings, double reach_m);

  /// No query of tracer() and light() may be running.
  void move_to(const Eigen::Vector2d& place);

  const Tracer& tracer() const { return tracer_; }
  const SoftLight& light() const { return light_; }
  size_t num_tiles() const { return tiles_.size(); }

 private:
  struct Tile;

  DistrictPlan plan_;
  double reach_m_;
  float light_cell_m_;
  std::map<DistrictTile, std::shared_ptr<Tile>> tiles_;
  std::optional<DistrictTile> middle_;
  Tracer tracer_;
  SoftLight light_;
};

}  // namespace cpplus
