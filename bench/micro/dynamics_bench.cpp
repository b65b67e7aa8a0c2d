// Removal of dynamic objects: what scans see through, by asking the leaves which rays pass them, beside steps of one
// leaf along each ray with a look-up each; and the whole stage. A room of 12 x 9 x 3 m as a LiDAR that walks through it
// sees it; a hall beside peers that keep free space.
#include <benchmark/benchmark.h>

#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/find_dynamics.h"
#include "cpplus/dynamics/leaf_surfaces.h"
#include "cpplus/dynamics/see_through.h"
#include "dynamics_bench_scans.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

constexpr size_t kBeams = 20000;

ScanSet room_scans(size_t num_scans) { return bench::room_scans({12.0, 9.0, 3.0}, num_scans, kBeams); }

/// Calls cast(direction, range) for each point of the first scan.
template <typename Cast>
void for_each_ray(const ScanSet& scans, const Cast& cast) {
  for (size_t i = 0; i < scans.first_point[1]; ++i) {
    const Vector3d ray = scans.points.point(i) - scans.sensors_in_map[0];
    cast(ray.normalized(), ray.norm());
  }
}

/// What the scans see through, which answers for the rays of all of them.
void BM_SeeThrough(benchmark::State& state) {
  const ScanSet scans = room_scans(10);
  const VoxelMap map(scans.points, {});
  const LeafSurfaces surfaces = measure_leaf_surfaces(map, scans);
  set_num_threads(1);
  for (auto _ : state) benchmark::DoNotOptimize(count_see_through(map, scans, surfaces, {}));
  set_num_threads(0);
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(scans.points.size()));
}
BENCHMARK(BM_SeeThrough)->Unit(benchmark::kMillisecond);

/// What stepping along the rays of one scan would take.
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

/// Cleaning of the hall, voxel map included. Argument: threads.
void BM_CleanHall(benchmark::State& state) {
  const ScanSet scans = bench::hall_scans();
  VoxelMapOptions voxels;
  voxels.leaf_size_m = bench::hall_voxel_m;
  voxels.root_size_m = 16 * bench::hall_voxel_m;
  set_num_threads(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(find_dynamics(VoxelMap(scans.points, voxels), scans, {}));
  set_num_threads(0);
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(scans.points.size()));
  state.counters["scans"] =
      benchmark::Counter(static_cast<double>(scans.num_scans()), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(BM_CleanHall)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cpplus

int main(int argc, char** argv) {
#ifdef CPPLUS_BENCH_OCTOMAP
  cpplus::bench::register_octomap();
#endif
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
