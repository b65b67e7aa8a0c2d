// How well creases and borders of simulated rooms are found: docs/map_edges.md states the figures printed here.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "cpplus/cloud/point_map.h"
#include "cpplus/features/map_edges.h"
#include "cpplus/features/plane_segmentation.h"
#include "cpplus/simulate/simulate.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 0.05;        // metres between samples of an edge
constexpr double kFalse = 0.03;       // metres; farther from every true edge an edge is false
constexpr double kMaxAngleDeg = 5.0;  // between an edge and its true edge

struct Accuracy {
  std::vector<double> distances_m;  // from the true edge, per sample of the edges that have one
  std::vector<double> angles_deg;   // per edge that has one
  size_t samples = 0;

  double false_share() const { return 1.0 - static_cast<double>(distances_m.size()) / static_cast<double>(samples); }
};

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

double angle_deg(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180.0 / M_PI;
}

// Nearest true edge of the same direction beside x; its distance is kFalse or more where there is none.
const TrueEdge* nearest(const std::vector<TrueEdge>& truth, const MapEdge& edge, const Vector3d& x, double* distance) {
  const TrueEdge* best = nullptr;
  *distance = kFalse;
  for (const TrueEdge& candidate : truth) {
    const Vector3d direction = (candidate.end - candidate.begin).normalized();
    const double t = direction.dot(x - candidate.begin);
    if (t < -kStep || t > (candidate.end - candidate.begin).norm() + kStep) continue;
    const double across = (x - candidate.begin - t * direction).norm();
    if (across >= *distance || angle_deg(direction, edge.direction()) > kMaxAngleDeg) continue;
    *distance = across;
    best = &candidate;
  }
  return best;
}

// Where a wall meets the ceiling of a room nothing protrudes by less than the noise, as skirting boards and frames do.
bool is_under_ceiling(const TrueEdge& edge) {
  constexpr double kLowestCeiling = 2.3;  // metres
  return std::min(edge.normal_a.z(), edge.normal_b.z()) < -0.99 && edge.begin.z() > kLowestCeiling &&
         (edge.end - edge.begin).norm() > 1.0;
}

void measure(const std::vector<MapEdge>& edges, const std::vector<TrueEdge>& truth, MapEdgeKind kind,
             Accuracy* accuracy, Accuracy* ceiling = nullptr) {
  for (const MapEdge& edge : edges) {
    if (edge.kind != kind) continue;
    const int samples = std::max(1, static_cast<int>(edge.length() / kStep));
    for (int k = 0; k < samples; ++k) {
      const Vector3d x = edge.start + (k + 0.5) / samples * (edge.end - edge.start);
      double distance = 0.0;
      const TrueEdge* true_edge = nearest(truth, edge, x, &distance);
      ++accuracy->samples;
      if (true_edge == nullptr) continue;
      for (Accuracy* a : {accuracy, is_under_ceiling(*true_edge) ? ceiling : nullptr}) {
        if (a == nullptr) continue;
        a->distances_m.push_back(distance);
        if (k == samples / 2) a->angles_deg.push_back(angle_deg(true_edge->end - true_edge->begin, edge.direction()));
      }
    }
  }
}

TEST(SlowMapEdges, CreasesOfSimulatedRooms) {
  Accuracy creases;
  Accuracy ceilings;
  Accuracy borders;
  for (const char* scene : {"room", "rooms"}) {
    for (const int seed : {1, 2}) {
      SimulateOptions options;
      options.scene = scene;
      options.seed = seed;
      options.width = 32;
      options.height = 24;
      options.images = 1;
      options.blurred = 0;
      options.render.samples_per_pixel = 1;
      options.lidar.range_noise_m = 0.02;
      options.scan_pose_sigma_m = 0.0;
      options.scan_pose_sigma_deg = 0.0;
      const SimulatedWorld world = simulate_world(options);
      const VoxelMap map(world.map, {});
      const auto edges = find_map_edges(map, in_map_order(map, world.map.intensities), segment_planes(map, {}), {});
      measure(edges, world.edges, MapEdgeKind::kCrease, &creases, &ceilings);
      measure(edges, world.edges, MapEdgeKind::kBoundary, &borders);
    }
  }
  std::printf("creases: %.0f m, %.1f mm, %.2f deg, %.0f %% false; under a ceiling: %.0f m, %.1f mm, %.2f deg\n",
              kStep * static_cast<double>(creases.samples), 1e3 * median(creases.distances_m),
              median(creases.angles_deg), 100.0 * creases.false_share(),
              kStep * static_cast<double>(ceilings.distances_m.size()), 1e3 * median(ceilings.distances_m),
              median(ceilings.angles_deg));
  std::printf("borders: %.0f m, %.1f mm, %.2f deg, %.0f %% beside no crease or corner of the scene\n",
              kStep * static_cast<double>(borders.samples), 1e3 * median(borders.distances_m),
              median(borders.angles_deg), 100.0 * borders.false_share());
  ASSERT_GT(kStep * static_cast<double>(ceilings.distances_m.size()), 20.0);
  EXPECT_LT(median(ceilings.distances_m), 0.002);
  EXPECT_LT(median(ceilings.angles_deg), 0.1);
  ASSERT_GT(kStep * static_cast<double>(creases.samples), 100.0);
  EXPECT_LT(median(creases.distances_m), 0.003);
  EXPECT_LT(median(creases.angles_deg), 0.2);
  EXPECT_LT(creases.false_share(), 0.24);
}

}  // namespace
}  // namespace cpplus
