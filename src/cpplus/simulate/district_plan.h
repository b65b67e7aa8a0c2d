#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>

#include "cpplus/simulate/scene.h"

namespace cpplus {

/// A tile of the city: the block of houses between four streets, with the halves of these streets that are next to it.
struct DistrictTile {
  int x = 0;
  int y = 0;
  auto operator<=>(const DistrictTile&) const = default;
};

/// A city on a square grid of streets, without end, of which a square is travelled; the map's origin is in the middle
/// of it. Everything follows from these numbers and the index of a tile, so that any tile can be made at any time.
struct DistrictPlan {
  uint64_t seed = 1;
  int num_streets = 2;  // that are travelled, in each of the two directions
  double pitch_m = 60.0;
  double road_m = 4.6;      // half width of the carriageway
  double pavement_m = 3.6;  // its width, kerb included
  double kerb_m = 0.13;     // height

  /// Middle of street k of either direction: x of one along y, y of one along x. Those with k in [0, num_streets) are
  /// travelled; tile (i, j) reaches from street i to i + 1 in x and from j to j + 1 in y.
  double street_m(int k) const { return (k - 0.5 * (num_streets - 1)) * pitch_m; }
  DistrictTile tile_at(const Eigen::Vector2d& position) const;
  /// Metres between the nearest points of two tiles.
  double distance_m(const DistrictTile& a, const DistrictTile& b) const;
};

/// The plan for an area: the streets' number and pitch (50 to 85 m) are such that each travelled street stands for a
/// strip of a pitch's width. At least 0.01 km².
DistrictPlan plan_district(double area_km2, uint64_t seed);

/// Through every travelled street, to and fro: first those along x, then those along y; on the right-hand lane, the
/// heading in turns to the front and to the houses.
Way district_way(const DistrictPlan& plan);

}  // namespace cpplus
