#include <benchmark/benchmark.h>
#include <octomap/octomap.h>

#include "voxel_map_bench_cloud.h"

namespace cpplus::bench {
namespace {

constexpr size_t points_a_scan = 50000;

/// Insertion of scans with free space, as OctoMap is used; each scan stands in the middle of a room.
void insertion(benchmark::State& state, const World& world) {
  const PointCloud& cloud = cloud_of(world);
  for (auto _ : state) {
    return_memory(&state);
    octomap::OcTree tree(leaf_size_m);
    octomap::Pointcloud scan;
    Eigen::Vector3f origin = room_center(cloud.positions[0]);
    const auto insert = [&] {
      tree.insertPointCloud(scan, octomap::point3d(origin.x(), origin.y(), origin.z()), -1, true);
      scan.clear();
    };
    for (const Eigen::Vector3f& x : cloud.positions) {
      const Eigen::Vector3f room = room_center(x);
      if (scan.size() == points_a_scan || (room != origin && scan.size() > 0)) insert();
      origin = room;
      scan.push_back(x.x(), x.y(), x.z());
    }
    insert();
    tree.updateInnerOccupancy();
    state.counters["bytes_per_point"] = static_cast<double>(tree.memoryUsage()) / static_cast<double>(world.num_points);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(world.num_points));
}

}  // namespace

void register_octomap(const World& world) {
  benchmark::RegisterBenchmark(("OctoMapInsertion/" + world.name()).c_str(), insertion, world)
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace cpplus::bench
