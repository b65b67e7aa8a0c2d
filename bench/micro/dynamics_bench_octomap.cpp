#include <benchmark/benchmark.h>
#include <octomap/octomap.h>

#include "dynamics_bench_scans.h"

namespace cpplus::bench {
namespace {

/// Insertion of all scans with their free space, inner nodes at the end. Argument: one ray for all points of a voxel.
void insertion(benchmark::State& state) {
  const ScanSet scans = hall_scans();
  for (auto _ : state) {
    octomap::OcTree tree(hall_voxel_m);
    for (size_t scan = 0; scan < scans.num_scans(); ++scan) {
      octomap::Pointcloud cloud;
      for (size_t i = scans.first_point[scan]; i < scans.first_point[scan + 1]; ++i) {
        const Eigen::Vector3f& x = scans.points.positions[i];
        cloud.push_back(x.x(), x.y(), x.z());
      }
      const Eigen::Vector3f sensor = scans.sensors_in_map[scan].cast<float>();
      tree.insertPointCloud(cloud, octomap::point3d(sensor.x(), sensor.y(), sensor.z()), -1, true, state.range(0) != 0);
    }
    tree.updateInnerOccupancy();
    benchmark::DoNotOptimize(tree.size());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(scans.points.size()));
}

}  // namespace

void register_octomap() {
  benchmark::RegisterBenchmark("OctoMapInsertion", insertion)
      ->ArgName("one_ray_a_voxel")
      ->Arg(0)
      ->Arg(1)
      ->MeasureProcessCPUTime()
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace cpplus::bench
