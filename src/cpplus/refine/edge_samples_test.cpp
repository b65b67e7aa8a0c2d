#include "cpplus/refine/edge_samples.h"

#include <gtest/gtest.h>

#include <set>

#include "cpplus/refine/test_room.h"

namespace cpplus {
namespace {

Camera pinhole() { return Camera(CameraModel::kPinhole, 640, 480, {400, 400, 319.5, 239.5}); }

// A camera at the origin that looks along +y of the map.
Rigid3 ahead() { return look_at({0, 0, 0}, {0, 1, 0}); }

MapEdge line(const Eigen::Vector3d& start, const Eigen::Vector3d& end) {
  MapEdge edge;
  edge.start = start;
  edge.end = end;
  return edge;
}

std::vector<EdgeSample> samples_of(const std::vector<MapEdge>& edges, const TestRoom& room,
                                   const Camera& camera = pinhole(), const Rigid3& camera_from_map = ahead()) {
  return sample_visible_edges(edges, camera, camera_from_map, cast_plane_buffer(room, camera, camera_from_map), {});
}

std::set<uint32_t> edges_seen(const std::vector<EdgeSample>& samples) {
  std::set<uint32_t> edges;
  for (const EdgeSample& sample : samples) edges.insert(sample.edge);
  return edges;
}

TEST(SampleVisibleEdges, ABoxShowsTheEdgesOfItsVisibleFacesOnly) {
  // Seen from in front, above and to the left, a cube hides the three edges that meet in the corner farthest away.
  const TestRoom room = make_room(std::nullopt, {{{0.6, 2.5, -1.2}, {1.2, 3.1, -0.6}}});
  const Eigen::Vector3d hidden_corner(1.2, 3.1, -1.2);
  const std::vector<EdgeSample> samples = samples_of(room.edges, room);
  const std::set<uint32_t> seen = edges_seen(samples);
  for (uint32_t i = 0; i < room.edges.size(); ++i) {
    const MapEdge& edge = room.edges[i];
    const bool hidden = edge.start.isApprox(hidden_corner) || edge.end.isApprox(hidden_corner);
    EXPECT_TRUE(hidden || seen.count(i) == 1) << i;
  }
  // Near its ends, where it meets a visible edge, a hidden edge may count: within the margin of visibility.
  for (const EdgeSample& sample : samples) {
    const MapEdge& edge = room.edges[sample.edge];
    if (!edge.start.isApprox(hidden_corner) && !edge.end.isApprox(hidden_corner)) continue;
    const Eigen::Vector3d far_end = edge.start.isApprox(hidden_corner) ? edge.end : edge.start;
    EXPECT_LT((sample.x_in_map - far_end).norm(), 0.12) << sample.edge;
  }
}

TEST(SampleVisibleEdges, AWallHidesWhatIsBehindIt) {
  const std::vector<MapEdge> edges = {line({-0.5, 4, 0}, {0.5, 4, 0}), line({-0.5, 1.5, 0.3}, {0.5, 1.5, 0.3})};
  const TestRoom wall = make_room(std::nullopt, {{{-3, 2, -3}, {3, 2.2, 3}}});
  EXPECT_EQ(edges_seen(samples_of(edges, wall)), std::set<uint32_t>{1});
  EXPECT_EQ(edges_seen(samples_of(edges, make_room(std::nullopt, {}))), (std::set<uint32_t>{0, 1}));
}

TEST(SampleVisibleEdges, ASilhouetteCountsWhateverThePlanesSay) {
  // It was found in what the view sees; no plane need be where it is, and one beyond does not have to be known.
  MapEdge trunk = line({0.2, 4, -0.5}, {0.2, 4, 0.5});
  trunk.kind = MapEdgeKind::kSilhouette;
  const TestRoom wall = make_room(std::nullopt, {{{-3, 2, -3}, {3, 2.2, 3}}});
  const std::vector<EdgeSample> samples = samples_of({trunk}, wall);
  // 1 m at 4 m with 400 px: 100 px.
  ASSERT_GE(samples.size(), 16u);
  for (const EdgeSample& sample : samples) EXPECT_EQ(sample.edge_samples, samples.size());
}

TEST(SampleVisibleEdges, AThinWallHidesTheEdgeOnItsOtherFace) {
  // A door frame on the far face of a wall of 6 cm.
  const TestRoom wall = make_room(std::nullopt, {{{-3, 2, -3}, {3, 2.06, 3}}});
  const std::vector<MapEdge> edges = {line({0.2, 2.00, -1}, {0.2, 2.00, 1}), line({0.4, 2.06, -1}, {0.4, 2.06, 1})};
  EXPECT_EQ(edges_seen(samples_of(edges, wall)), std::set<uint32_t>{0});
}

// A panel at y = 2 that ends at x = 0.5; its boundary there. Only `beyond` tells whether it counts.
std::set<uint32_t> panel_boundary_seen(const std::vector<Box>& beyond) {
  std::vector<Box> boxes = {{{-1, 2.0, -1}, {0.5, 2.02, 1}}};
  boxes.insert(boxes.end(), beyond.begin(), beyond.end());
  MapEdge boundary = line({0.5, 2.0, -0.6}, {0.5, 2.0, 0.6});
  boundary.kind = MapEdgeKind::kBoundary;
  boundary.normal_a = {0, -1, 0};
  boundary.inward_a = {-1, 0, 0};
  return edges_seen(samples_of({boundary}, make_room(std::nullopt, boxes)));
}

TEST(SampleVisibleEdges, ABoundaryCountsWhereSomethingFartherIsSeenBeyondIt) {
  EXPECT_EQ(panel_boundary_seen({{{-4, 3.0, -4}, {4, 3.2, 4}}}).size(), 1u);
}

TEST(SampleVisibleEdges, TheBorderOfAShadowIsNoBoundary) {
  EXPECT_TRUE(panel_boundary_seen({}).empty()) << "nothing beyond";
  EXPECT_TRUE(panel_boundary_seen({{{0.5, 2.0, -1}, {3, 2.02, 1}}}).empty()) << "the same plane beyond";
  EXPECT_TRUE(panel_boundary_seen({{{0.5, 1.2, -1}, {3, 1.4, 1}}}).empty()) << "what cast the shadow beyond";
}

TEST(SampleVisibleEdges, SamplesAreSpacedInPixels) {
  // 1 m at 2 m is 200 px, at 4 m 100 px.
  const TestRoom empty = make_room(std::nullopt, {});
  const std::vector<EdgeSample> samples =
      samples_of({line({-0.5, 2, 0.1}, {0.5, 2, 0.1}), line({-0.5, 4, 0.1}, {0.5, 4, 0.1})}, empty);
  const double spacing_px = EdgeSampleOptions().spacing_px;
  std::vector<size_t> counts(2);
  for (size_t i = 0; i < samples.size(); ++i) {
    ++counts[samples[i].edge];
    if (i == 0 || samples[i].edge != samples[i - 1].edge) continue;
    const double step =
        (*pinhole().project(ahead() * samples[i].x_in_map) - *pinhole().project(ahead() * samples[i - 1].x_in_map))
            .norm();
    EXPECT_NEAR(step, spacing_px, 0.25 * spacing_px);
  }
  EXPECT_NEAR(static_cast<double>(counts[0]), 200 / spacing_px, 2);
  EXPECT_NEAR(static_cast<double>(counts[1]), 100 / spacing_px, 2);
  for (const EdgeSample& sample : samples) EXPECT_EQ(sample.edge_samples, counts[sample.edge]);
}

TEST(SampleVisibleEdges, SamplesOfAnEdgeThatRunsAwayDoNotCrowd) {
  // A corridor's edge from 1 to 30 m: without care half of its samples fall on a few pixels.
  const std::vector<EdgeSample> samples =
      samples_of({line({0.4, 1, -0.3}, {0.4, 30, -0.3})}, make_room(std::nullopt, {}));
  ASSERT_GT(samples.size(), 10u);
  for (size_t i = 1; i < samples.size(); ++i) {
    const double step =
        (*pinhole().project(ahead() * samples[i].x_in_map) - *pinhole().project(ahead() * samples[i - 1].x_in_map))
            .norm();
    EXPECT_GT(step, 0.5 * EdgeSampleOptions().spacing_px);
  }
}

TEST(SampleVisibleEdges, DistortionDecidesWhatFallsIntoTheImage) {
  // At 40 degrees off the axis: out of the pinhole's image (400 tan 40 = 336 px), within that of a barrel distortion.
  const double x = 2 * std::tan(40 * std::numbers::pi / 180);
  const std::vector<MapEdge> edges = {line({x, 2, -0.3}, {x, 2, 0.3})};
  const TestRoom empty = make_room(std::nullopt, {});
  EXPECT_TRUE(samples_of(edges, empty).empty());
  const Camera barrel(CameraModel::kOpenCv, 640, 480, {400, 400, 319.5, 239.5, -0.25, 0.06, 0, 0});
  const std::vector<EdgeSample> samples = samples_of(edges, empty, barrel);
  EXPECT_FALSE(samples.empty());
  for (const EdgeSample& sample : samples) {
    const auto pixel = barrel.project(ahead() * sample.x_in_map);
    ASSERT_TRUE(pixel);
    EXPECT_TRUE(barrel.in_image(*pixel));
  }
}

TEST(SampleVisibleEdges, BehindTheCameraAndFarAwayNothingIsSampled) {
  const TestRoom empty = make_room(std::nullopt, {});
  EXPECT_TRUE(samples_of({line({-1, -3, 0.1}, {1, -3, 0.1})}, empty).empty());
  EXPECT_TRUE(samples_of({line({-10, 70, 0.1}, {10, 70, 0.1})}, empty).empty());
  EXPECT_TRUE(samples_of({}, empty).empty());
}

TEST(SampleVisibleEdges, InAFurnishedRoomSamplesAgreeWithExactVisibility) {
  const TestRoom room = furnished_room();
  const Camera camera = test_camera();
  const std::vector<EdgeSample> samples = samples_of(room.edges, room, camera, true_view());
  const Eigen::Vector3d center = camera_center(true_view());
  EXPECT_GT(samples.size(), 300u);
  size_t kept_visible = 0;
  for (const EdgeSample& sample : samples) {
    kept_visible += truly_visible(room, center, sample.x_in_map);
    // A hidden sample counts only close to the outline of what hides it.
    const Eigen::Vector2d pixel = *camera.project(true_view() * sample.x_in_map);
    bool seen_beside = false;
    for (int k = 0; k < 16; ++k) {
      const double angle = k * std::numbers::pi / 8;
      const auto bearing = camera.unproject(pixel + 9.0 * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
      const Eigen::Vector3d beside = true_view().rotation.conjugate() * *bearing;
      seen_beside |= truly_visible(room, center, center + (sample.x_in_map - center).norm() * beside);
    }
    EXPECT_TRUE(seen_beside) << "edge " << sample.edge << " at " << sample.x_in_map.transpose();
  }
  PlaneBuffer nothing_hidden = cast_plane_buffer(make_room(std::nullopt, {}), camera, true_view());
  nothing_hidden.planes = &room.planes;
  size_t all_visible = 0;
  for (const EdgeSample& sample : sample_visible_edges(room.edges, camera, true_view(), nothing_hidden, {})) {
    all_visible += truly_visible(room, center, sample.x_in_map);
  }
  EXPECT_GE(static_cast<double>(kept_visible), 0.99 * static_cast<double>(all_visible));
}

// A raster of one range wherever pixels are in [begin, end) along x, and of nothing elsewhere.
RangeRaster raster_of(double range_m, int begin_px, int end_px) {
  RangeRaster raster;
  raster.range = RangeImage(320, 240, 0.0f);
  for (int y = 0; y < 240; ++y) {
    for (int x = begin_px / 2; x < end_px / 2; ++x) raster.range.at(x, y) = static_cast<float>(range_m);
  }
  return raster;
}

TEST(DropHiddenSamples, WhatTheNearestPointsHideIsLeftOut) {
  // 1 m at 4 m with 400 px: from pixel 269.5 to 369.5, and points of no plane at 3 m on the left half.
  const std::vector<EdgeSample> all = samples_of({line({-0.5, 4, 0}, {0.5, 4, 0})}, make_room(std::nullopt, {}));
  std::vector<EdgeSample> seen = all;
  drop_hidden_samples(raster_of(3.0, 0, 320), pinhole(), ahead(), {}, &seen);
  ASSERT_GT(seen.size(), all.size() / 3);
  ASSERT_LT(seen.size(), all.size() * 2 / 3);
  for (const EdgeSample& sample : seen) {
    EXPECT_GT(sample.x_in_map.x(), -0.03) << "within the cells around the end of what hides";
    EXPECT_EQ(sample.edge_samples, seen.size());
  }
}

TEST(DropHiddenSamples, WhatLiesOnTheNearestSurfaceStays) {
  const std::vector<EdgeSample> all = samples_of({line({-0.5, 4, 0}, {0.5, 4, 0})}, make_room(std::nullopt, {}));
  // No surface, the edge's own, and one nearer by less and by more than the margin of 10 cm.
  for (const double range : {0.0, 4.0, 3.95, 5.0}) {
    std::vector<EdgeSample> seen = all;
    drop_hidden_samples(raster_of(range, 0, 640), pinhole(), ahead(), {}, &seen);
    EXPECT_EQ(seen.size(), all.size()) << range;
  }
  std::vector<EdgeSample> seen = all;
  drop_hidden_samples(raster_of(3.85, 0, 640), pinhole(), ahead(), {}, &seen);
  EXPECT_TRUE(seen.empty());
}

TEST(DropHiddenSamples, SamplesOfEachEdgeAreCountedAnew) {
  const TestRoom empty = make_room(std::nullopt, {});
  std::vector<EdgeSample> samples =
      samples_of({line({-0.5, 4, 0.1}, {0.5, 4, 0.1}), line({-0.5, 2, 0.1}, {0.5, 2, 0.1})}, empty);
  drop_hidden_samples(raster_of(3.0, 0, 300), pinhole(), ahead(), {}, &samples);
  std::vector<uint32_t> counts(2);
  for (const EdgeSample& sample : samples) ++counts[sample.edge];
  EXPECT_GT(counts[1], counts[0]) << "the second one is nearer than what hides";
  for (const EdgeSample& sample : samples) EXPECT_EQ(sample.edge_samples, counts[sample.edge]);
}

}  // namespace
}  // namespace cpplus
