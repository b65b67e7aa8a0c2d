#include "cpplus/pipeline/join_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <set>

#include "cpplus/cloud/map_part.h"
#include "cpplus/core/parallel.h"
#include "cpplus/features/test_surfaces.h"
#include "cpplus/pipeline/tile_features.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

constexpr double kHaloM = 4.0;

/// A floor of 20 x 20 m with walls on two sides, of which one is painted, and two free-standing walls, one of them in
/// the plane x = 10, which is the border of tiles.
PointCloud hall() {
  Random random(4);
  PointCloud cloud;
  constexpr double kDensity = 1000;
  constexpr double kNoise = 0.006;
  const auto add = [&](const Vector3d& corner, const Vector3d& u, const Vector3d& v, float intensity = 100.0f) {
    add_surface(corner, u, v, kDensity, kNoise, &random, &cloud, intensity);
  };
  add({0.1, 0.1, 0.3}, {19.8, 0, 0}, {0, 19.8, 0});
  add({0.1, 0.1, 0.3}, {19.8, 0, 0}, {0, 0, 0.9});
  add({0.1, 0.1, 1.2}, {19.8, 0, 0}, {0, 0, 1.1}, 40.0f);
  add({0.1, 0.1, 0.3}, {0, 19.8, 0}, {0, 0, 1.6});
  add({10, 3.3, 0.3}, {0, 5.2, 0}, {0, 0, 1.4});
  add({4.4, 13.1, 0.3}, {8.3, 2.2, 0}, {0, 0, 1.3});
  return cloud;
}

class JoinTiles : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    points_ = std::make_unique<PointMap>(make_point_map(hall(), {}));
    Progress progress("map", kMapSteps);
    whole_ = std::make_unique<MapFeatures>(extract_map_features(*points_, {}, &progress));
    tiles_ = divide_map(points_->map, points_->map.num_points() / 4);
    found_ = find_tiles();
    joined_ = std::make_unique<MapFeatures>(join_all(found_));
  }
  static void TearDownTestSuite() {
    points_.reset();
    whole_.reset();
    joined_.reset();
  }

  static std::vector<TileFeatures> find_tiles() {
    Progress progress("map", kMapSteps * tiles_.size());
    std::vector<TileFeatures> found;
    for (const MapTile& tile : tiles_)
      found.push_back(find_tile_features(*points_, tile, kHaloM, sampled_noise_m(points_->map, {}), {}, &progress));
    return found;
  }

  static MapFeatures join_all(const std::vector<TileFeatures>& found) {
    std::vector<uint32_t> roots(points_->map.num_nodes(0));
    std::iota(roots.begin(), roots.end(), 0u);
    std::vector<const MapTile*> tiles;
    for (const MapTile& tile : tiles_) tiles.push_back(&tile);
    return join_tiles(points_->map, points_->map, roots, tiles, found, {});
  }

  static std::unique_ptr<PointMap> points_;
  static std::unique_ptr<MapFeatures> whole_;
  static std::vector<MapTile> tiles_;
  static std::vector<TileFeatures> found_;
  static std::unique_ptr<MapFeatures> joined_;
};

std::unique_ptr<PointMap> JoinTiles::points_;
std::unique_ptr<MapFeatures> JoinTiles::whole_;
std::vector<MapTile> JoinTiles::tiles_;
std::vector<TileFeatures> JoinTiles::found_;
std::unique_ptr<MapFeatures> JoinTiles::joined_;

void expect_same(const std::vector<MapEdge>& edges, const std::vector<MapEdge>& expected) {
  ASSERT_EQ(edges.size(), expected.size());
  for (size_t i = 0; i < edges.size(); ++i) {
    EXPECT_EQ(edges[i].start, expected[i].start);
    EXPECT_EQ(edges[i].end, expected[i].end);
    EXPECT_EQ(edges[i].covariance, expected[i].covariance);
    EXPECT_EQ(edges[i].group, expected[i].group);
  }
}

void expect_same(const MapFeatures& features, const MapFeatures& expected) {
  EXPECT_EQ(features.planes.noise_m, expected.planes.noise_m);
  ASSERT_EQ(features.planes.planes.size(), expected.planes.planes.size());
  for (size_t i = 0; i < features.planes.planes.size(); ++i) {
    EXPECT_EQ(features.planes.planes[i].normal, expected.planes.planes[i].normal);
    EXPECT_EQ(features.planes.planes[i].centroid, expected.planes.planes[i].centroid);
    EXPECT_EQ(features.planes.planes[i].num_points, expected.planes.planes[i].num_points);
  }
  EXPECT_EQ(features.surface.leaves, expected.surface.leaves);
  EXPECT_EQ(features.surface.plane_of, expected.surface.plane_of);
  EXPECT_EQ(features.surface.centers, expected.surface.centers);
  EXPECT_EQ(features.leaf_spacing, expected.leaf_spacing);
  expect_same(features.edges, expected.edges);
}

TEST_F(JoinTiles, OneTileHasTheFeaturesOfTheMap) {
  const auto tiles = divide_map(points_->map, points_->map.num_points());
  ASSERT_EQ(tiles.size(), 1u);
  Progress progress("map", kMapSteps);
  const std::vector<TileFeatures> found = {find_tile_features(*points_, tiles[0], kHaloM, std::nullopt, {}, &progress)};
  expect_same(join_tiles(points_->map, points_->map, tiles[0].roots, {&tiles[0]}, found, {}), *whole_);
}

TEST_F(JoinTiles, ThreadsDoNotMatter) {
  for (const int threads : {1, 2}) {
    set_num_threads(threads);
    expect_same(join_all(find_tiles()), *joined_);
  }
  set_num_threads(0);
}

double angle_deg(const Vector3d& a, const Vector3d& b) {
  return std::acos(std::min(1.0, std::abs(a.dot(b)))) * 180.0 / std::numbers::pi;
}

TEST_F(JoinTiles, PlanesAcrossBordersAreOne) {
  ASSERT_EQ(tiles_.size(), 4u);
  const auto is_large = [](const MapPlane& plane) { return plane.num_points > 2000; };
  const std::vector<MapPlane>& planes = joined_->planes.planes;
  const std::vector<MapPlane>& expected = whole_->planes.planes;
  EXPECT_EQ(std::count_if(planes.begin(), planes.end(), is_large), 5) << "the floor and four walls";
  EXPECT_EQ(std::count_if(expected.begin(), expected.end(), is_large), 5);
  for (const MapPlane& plane : expected) {
    if (!is_large(plane)) continue;
    const auto same = std::find_if(planes.begin(), planes.end(), [&](const MapPlane& other) {
      return angle_deg(plane.normal, other.normal) < 0.1 && (plane.centroid - other.centroid).norm() < 0.05;
    });
    ASSERT_NE(same, planes.end()) << plane.normal.transpose() << " at " << plane.centroid.transpose();
    EXPECT_LT(std::abs(plane.signed_distance(same->centroid)), 2e-4);
    EXPECT_NEAR(same->num_points, plane.num_points, 0.01 * plane.num_points);
    EXPECT_NEAR(same->sigma_m, plane.sigma_m, 1e-4);
  }
}

TEST_F(JoinTiles, TilesKnowNothingOfEachOthersPlanes) {
  for (const TileFeatures& tile : found_) {
    EXPECT_GE(tile.planes.size(), 2u) << "the test tests nothing where the floor is in one tile";
    EXPECT_FALSE(tile.patches_around.empty());
  }
}

TEST_F(JoinTiles, TheSurfaceIsThatOfTheWholeMap) {
  const PlaneSurface& surface = joined_->surface;
  EXPECT_TRUE(std::is_sorted(surface.leaves.begin(), surface.leaves.end()));
  EXPECT_NEAR(static_cast<double>(surface.leaves.size()), static_cast<double>(whole_->surface.leaves.size()),
              0.005 * static_cast<double>(whole_->surface.leaves.size()));
  const VoxelMap& map = points_->map;
  for (size_t k = 0; k < surface.leaves.size(); k += 7) {
    const Vector3d center = surface.centers[k].cast<double>() + map.origin();
    ASSERT_EQ(map.find_leaf(center), surface.leaves[k]) << k;
    const MapPlane& plane = joined_->planes.planes[static_cast<size_t>(surface.plane_of[k])];
    EXPECT_LT(std::abs(plane.signed_distance(center)), 0.03);
  }
  EXPECT_EQ(joined_->leaf_spacing, whole_->leaf_spacing);
}

TEST_F(JoinTiles, OfSomeRootsTheSurfaceCountsTheirLeaves) {
  const auto roots = roots_near(points_->map, std::vector<Vector3d>{{10.0, 10.0, 0.0}}, 3.0);
  const PointMap near = part_of_map(*points_, roots);
  std::vector<const MapTile*> tiles;
  for (const MapTile& tile : tiles_) tiles.push_back(&tile);
  const MapFeatures features = join_tiles(points_->map, near.map, roots, tiles, found_, {});
  EXPECT_EQ(features.leaf_spacing.size(), near.map.num_nodes(near.map.leaf_layer()));
  EXPECT_GT(features.surface.leaves.size(), 500u);
  for (size_t k = 0; k < features.surface.leaves.size(); ++k) {
    const Vector3d center = features.surface.centers[k].cast<double>() + near.map.origin();
    ASSERT_EQ(near.map.find_leaf(center), features.surface.leaves[k]) << k;
  }
  EXPECT_LT(features.planes.planes.size(), joined_->planes.planes.size()) << "the outer walls are not there";
}

/// Edges that run along this one through a point of it.
int count_along(const std::vector<MapEdge>& edges, const MapEdge& edge, const Vector3d& x, double distance_m,
                std::set<uint32_t>* groups = nullptr) {
  int count = 0;
  for (const MapEdge& other : edges) {
    const double along = other.direction().dot(x - other.start);
    const bool runs_along = std::abs(other.direction().dot(edge.direction())) > 0.99 && along >= 0 &&
                            along <= other.length() &&
                            (x - other.start - along * other.direction()).norm() < distance_m;
    count += runs_along;
    if (runs_along && groups != nullptr) groups->insert(other.group);
  }
  return count;
}

/// Of the length of some edges, the share along which there are `fewest` to `most` of the others.
double share_with(const std::vector<MapEdge>& edges, const std::vector<MapEdge>& others, int fewest, int most) {
  double there = 0.0;
  double all = 0.0;
  for (const MapEdge& edge : edges) {
    for (double along = 0.01; along < edge.length(); along += 0.02) {
      const int count = count_along(others, edge, edge.start + along * edge.direction(), 0.02);
      there += count >= fewest && count <= most ? 1.0 : 0.0;
      all += 1.0;
    }
  }
  return all > 0.0 ? there / all : 0.0;
}

std::vector<MapEdge> of_kind(const std::vector<MapEdge>& edges, MapEdgeKind kind) {
  std::vector<MapEdge> some;
  std::copy_if(edges.begin(), edges.end(), std::back_inserter(some), [&](const auto& e) { return e.kind == kind; });
  return some;
}

/// Where tiles meet: farther off a tile's edges are those that it found, some stretches of an intensity edge twice.
std::vector<MapEdge> near_borders(const std::vector<MapEdge>& edges) {
  std::vector<MapEdge> some;
  std::copy_if(edges.begin(), edges.end(), std::back_inserter(some), [](const MapEdge& edge) {
    const Vector3d middle = 0.5 * (edge.start + edge.end);
    return std::abs(middle.x() - 10.0) < 2.0 || std::abs(middle.y() - 10.0) < 2.0;
  });
  return some;
}

TEST_F(JoinTiles, EdgesAreThoseOfTheWholeMapAndOnceEachAtBorders) {
  for (const MapEdgeKind kind : {MapEdgeKind::kCrease, MapEdgeKind::kIntensity, MapEdgeKind::kBoundary}) {
    const auto edges = of_kind(joined_->edges, kind);
    const auto expected = of_kind(whole_->edges, kind);
    ASSERT_GT(expected.size(), 5u);
    EXPECT_GT(share_with(expected, edges, 1, 9), 0.97) << static_cast<int>(kind) << ": missing";
    EXPECT_GT(share_with(edges, expected, 1, 9), 0.97) << static_cast<int>(kind) << ": not there on the whole map";
    EXPECT_GT(share_with(near_borders(edges), edges, 1, 1), 0.99) << static_cast<int>(kind) << ": twice";
  }
}

TEST_F(JoinTiles, WhereEachTileIsLookedAtWithAllOfTheMapNothingIsMissingAndNothingAdded) {
  constexpr double kAllM = 100.0;
  const double noise_m = sampled_noise_m(points_->map, {});
  EXPECT_EQ(noise_m, whole_->planes.noise_m);
  Progress progress("map", kMapSteps * tiles_.size());
  std::vector<TileFeatures> found;
  for (const MapTile& tile : tiles_) {
    found.push_back(find_tile_features(*points_, tile, kAllM, noise_m, {}, &progress));
  }
  const MapFeatures joined = join_all(found);
  EXPECT_EQ(joined.planes.planes.size(), whole_->planes.planes.size());
  EXPECT_EQ(joined.surface.leaves, whole_->surface.leaves);
  EXPECT_EQ(joined.surface.centers, whole_->surface.centers);
  EXPECT_EQ(share_with(whole_->edges, joined.edges, 1, 9), 1.0);
  EXPECT_EQ(share_with(joined.edges, whole_->edges, 1, 9), 1.0);
}

TEST_F(JoinTiles, AnEdgeAcrossABorderIsOneGroup) {
  for (const auto& [start, kind] : {std::pair(Vector3d(7, 0.1, 0.3), MapEdgeKind::kCrease),
                                    std::pair(Vector3d(7, 0.1, 1.2), MapEdgeKind::kIntensity)}) {
    const auto edges = of_kind(joined_->edges, kind);
    MapEdge line;
    line.start = start;
    line.end = start + Vector3d(6, 0, 0);
    std::set<uint32_t> groups;
    for (double x = 0.0; x < 6.0; x += 0.05) {
      const int count = count_along(edges, line, start + Vector3d(x, 0, 0), 0.02, &groups);
      EXPECT_EQ(count, 1) << "at x = " << 7.0 + x;
    }
    EXPECT_EQ(groups.size(), 1u) << static_cast<int>(kind);
  }
}

TEST_F(JoinTiles, AnEdgeAlongABorderIsThereOnce) {
  EXPECT_EQ(tiles_[0].box.max().x(), 10.0) << "the test tests nothing where the wall is off the border";
  MapEdge line;
  line.start = Vector3d(10.0, 3.5, 0.3);
  line.end = Vector3d(10.0, 8.3, 0.3);
  for (double y = 0.0; y < 4.8; y += 0.05) {
    EXPECT_EQ(count_along(joined_->edges, line, line.start + Vector3d(0, y, 0), 0.02), 1) << "at y = " << 3.5 + y;
  }
}

}  // namespace
}  // namespace cpplus
