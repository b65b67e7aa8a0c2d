#include <benchmark/benchmark.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/octree/octree_search.h>
#include <pcl/point_types.h>

#include "voxel_map_bench_cloud.h"

namespace cpplus::bench {
namespace {

pcl::PointCloud<pcl::PointXYZ>::Ptr pcl_cloud(const World& world) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Eigen::Vector3f& x : cloud_of(world).positions) cloud->emplace_back(x.x(), x.y(), x.z());
  return cloud;
}

void voxel_grid(benchmark::State& state, const World& world) {
  const auto cloud = pcl_cloud(world);
  for (auto _ : state) {
    return_memory(&state);
    pcl::VoxelGrid<pcl::PointXYZ> grid;
    grid.setInputCloud(cloud);
    grid.setLeafSize(leaf_size_m, leaf_size_m, leaf_size_m);
    pcl::PointCloud<pcl::PointXYZ> centroids;
    grid.filter(centroids);
    benchmark::DoNotOptimize(centroids.points.data());
    state.counters["leaves"] = static_cast<double>(centroids.size());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(world.num_points));
}

void octree(benchmark::State& state, const World& world) {
  const auto cloud = pcl_cloud(world);
  for (auto _ : state) {
    return_memory(&state);
    pcl::octree::OctreePointCloudSearch<pcl::PointXYZ> tree(leaf_size_m);
    tree.setInputCloud(cloud);
    tree.addPointsFromInputCloud();
    state.counters["leaves"] = static_cast<double>(tree.getLeafCount());
    state.PauseTiming();  // its destruction is not counted
    tree.deleteTree();
    state.ResumeTiming();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(world.num_points));
}

}  // namespace

void register_pcl(const World& world) {
  benchmark::RegisterBenchmark(("PclVoxelGrid/" + world.name()).c_str(), voxel_grid, world)
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark(("PclOctree/" + world.name()).c_str(), octree, world)
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace cpplus::bench
