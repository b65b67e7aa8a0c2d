#include <benchmark/benchmark.h>
#include <open3d/geometry/PointCloud.h>

#include "voxel_map_bench_cloud.h"

namespace cpplus::bench {
namespace {

void voxel_down_sample(benchmark::State& state, const World& world) {
  open3d::geometry::PointCloud cloud;
  for (const Eigen::Vector3f& x : cloud_of(world).positions) cloud.points_.push_back(x.cast<double>());
  for (auto _ : state) {
    return_memory(&state);
    const auto centroids = cloud.VoxelDownSample(leaf_size_m);
    state.counters["leaves"] = static_cast<double>(centroids->points_.size());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(world.num_points));
}

}  // namespace

void register_open3d(const World& world) {
  benchmark::RegisterBenchmark(("Open3dVoxelDownSample/" + world.name()).c_str(), voxel_down_sample, world)
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace cpplus::bench
