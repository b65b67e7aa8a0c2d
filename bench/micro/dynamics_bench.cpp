// Removal of dynamic objects: rays through the voxel map by skipping empty voxels of all layers, beside steps of one
// leaf with a look-up each; and the whole stage. A room of 12 x 9 x 3 m as a LiDAR that walks through it sees it.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"
#include "cpplus/dynamics/find_dynamics.h"
#include "cpplus/dynamics/leaf_ray.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

constexpr size_t kBeams = 20000;

/// Scans of an empty room from places along its middle, in which somebody 0.5 m wide walks ahead of the sensor.
ScanSet room_scans(size_t num_scans) {
  const Vector3d room(12.0, 9.0, 3.0);
  Random random(1);
  ScanSet scans;
  for (size_t scan = 0; scan < num_scans; ++scan) {
    const Vector3d sensor(1.0 + 8.0 * static_cast<double>(scan) / static_cast<double>(num_scans), 4.5, 1.5);
    for (size_t beam = 0; beam < kBeams; ++beam) {
      const Vector3d direction = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
      double range = std::numeric_limits<double>::infinity();
      for (int a = 0; a < 3; ++a) {
        range = std::min(range, ((direction[a] > 0.0 ? room[a] : 0.0) - sensor[a]) / direction[a]);
      }
      const double to_person = 1.5 / direction.x();
      const bool meets_person = to_person > 0.0 && std::abs(to_person * direction.y()) < 0.25;
      if (meets_person) range = std::min(range, to_person);
      scans.points.positions.push_back((sensor + (range + 0.02 * random.normal()) * direction).cast<float>());
    }
    scans.first_point.push_back(scans.points.size());
    scans.sensors_in_map.push_back(sensor);
  }
  return scans;
}

/// Calls cast(direction, range) for each point of the first scan.
template <typename Cast>
void for_each_ray(const ScanSet& scans, const Cast& cast) {
  for (size_t i = 0; i < scans.first_point[1]; ++i) {
    const Vector3d ray = scans.points.point(i) - scans.sensors_in_map[0];
    cast(ray.normalized(), ray.norm());
  }
}

void BM_LeafRays(benchmark::State& state) {
  const ScanSet scans = room_scans(10);
  const VoxelMap map(scans.points, {});
  const LeafRayCaster caster(map, scans.sensors_in_map[0], 50.0);
  for (auto _ : state) {
    size_t num_met = 0;
    for_each_ray(scans, [&](const Vector3d& direction, double range) {
      caster.cast(direction, range, [&](uint32_t) { ++num_met; });
    });
    benchmark::DoNotOptimize(num_met);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kBeams));
}
BENCHMARK(BM_LeafRays)->Unit(benchmark::kMillisecond);

void BM_LeafByLeaf(benchmark::State& state) {
  const ScanSet scans = room_scans(10);
  const VoxelMap map(scans.points, {});
  const double step = map.options().leaf_size_m;
  for (auto _ : state) {
    size_t num_met = 0;
    for_each_ray(scans, [&](const Vector3d& direction, double range) {
      for (double along = 0.0; along < range; along += step) {
        num_met += map.find_leaf(scans.sensors_in_map[0] + along * direction) ? 1 : 0;
      }
    });
    benchmark::DoNotOptimize(num_met);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kBeams));
}
BENCHMARK(BM_LeafByLeaf)->Unit(benchmark::kMillisecond);

/// Arguments: scans, threads. Without the voxel map.
void BM_FindDynamics(benchmark::State& state) {
  const ScanSet scans = room_scans(static_cast<size_t>(state.range(0)));
  const VoxelMap map(scans.points, {});
  set_num_threads(static_cast<int>(state.range(1)));
  for (auto _ : state) benchmark::DoNotOptimize(find_dynamics(map, scans, {}));
  set_num_threads(0);
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(scans.points.size()));
}
BENCHMARK(BM_FindDynamics)->ArgsProduct({{40, 400}, {1, 2}})->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace cpplus

BENCHMARK_MAIN();
