// Building the voxel map and looking things up in it, beside the structures of other libraries.
//
//   voxel_map_bench --benchmark_repetitions=5 --benchmark_report_aggregates_only=true
//
// The sizes follow each other, with all libraries on one size side by side, so that ratios come from the same minutes.

#include <benchmark/benchmark.h>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"
#include "voxel_map_bench_cloud.h"

namespace cpplus::bench {
namespace {

void build(benchmark::State& state, const World& world, int threads) {
  const PointCloud& cloud = cloud_of(world);
  set_num_threads(threads);
  for (auto _ : state) {
    return_memory(&state);
    const VoxelMap map(cloud, {.root_size_m = 2.0, .leaf_size_m = leaf_size_m});
    state.counters["leaves"] = map.num_nodes(map.leaf_layer());
    state.counters["bytes_per_point"] = static_cast<double>(map.memory_bytes()) / static_cast<double>(map.num_points());
  }
  set_num_threads(0);
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(world.num_points));
}

/// 26 neighbours of every seventh leaf, as the dilation of a view asks for them; an item is one of the 26.
void leaf_neighbors(benchmark::State& state, const World& world) {
  const VoxelMap map(cloud_of(world), {.root_size_m = 2.0, .leaf_size_m = leaf_size_m});
  std::vector<uint32_t> neighbors;
  uint32_t leaf = 0;
  for (auto _ : state) {
    map.neighbors(map.leaf_layer(), leaf, false, &neighbors);
    benchmark::DoNotOptimize(neighbors.data());
    leaf = (leaf + 7) % map.num_nodes(map.leaf_layer());
  }
  state.SetItemsProcessed(state.iterations() * 26);
}

/// Cells along rays from the middle of a room, a leaf a step.
void find_along_rays(benchmark::State& state, const World& world) {
  const VoxelMap map(cloud_of(world), {.root_size_m = 2.0, .leaf_size_m = leaf_size_m});
  Random random(2);
  std::vector<Eigen::Vector3d> positions;
  for (int ray = 0; ray < 1000; ++ray) {
    const Eigen::Vector3d direction = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const Eigen::Vector3d eye = room_center(map.positions()[random.below(map.num_points())]).cast<double>();
    for (int step = 0; step < 100; ++step) positions.push_back(eye + step * leaf_size_m * direction);
  }
  size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(map.find_leaf(positions[i]));
    i = (i + 1) % positions.size();
  }
  state.SetItemsProcessed(state.iterations());
}

void layer_statistics(benchmark::State& state, const World& world, int layer) {
  const VoxelMap map(cloud_of(world), {.root_size_m = 2.0, .leaf_size_m = leaf_size_m});
  uint32_t node = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(map.statistics(layer, node));
    node = (node + 1) % map.num_nodes(layer);
  }
  state.SetItemsProcessed(state.iterations());
}

void roots_of_view(benchmark::State& state, const World& world) {
  const VoxelMap map(cloud_of(world), {.root_size_m = 2.0, .leaf_size_m = leaf_size_m});
  const Eigen::Vector3d eye = room_center(map.positions()[0]).cast<double>();
  for (auto _ : state) benchmark::DoNotOptimize(map.roots_in_frustum(eye, Eigen::Vector3d::UnitX(), 0.7, 20.0));
}

void register_all(const World& world) {
  for (int threads : {1, 2}) {
    const std::string name = "VoxelMapBuild/" + world.name() + "/threads:" + std::to_string(threads);
    benchmark::RegisterBenchmark(name.c_str(), build, world, threads)->UseRealTime()->Unit(benchmark::kMillisecond);
  }
#ifdef CPPLUS_BENCH_PCL
  register_pcl(world);
#endif
#ifdef CPPLUS_BENCH_OPEN3D
  register_open3d(world);
#endif
#ifdef CPPLUS_BENCH_OCTOMAP
  register_octomap(world);
#endif
}

void register_lookups(const World& world) {
  benchmark::RegisterBenchmark(("LeafNeighbors/" + world.name()).c_str(), leaf_neighbors, world);
  benchmark::RegisterBenchmark(("FindAlongRays/" + world.name()).c_str(), find_along_rays, world);
  benchmark::RegisterBenchmark(("RootsOfView/" + world.name()).c_str(), roots_of_view, world);
  for (int layer : {0, 4, 5}) {
    const std::string name = "Statistics/" + world.name() + "/layer:" + std::to_string(layer);
    benchmark::RegisterBenchmark(name.c_str(), layer_statistics, world, layer);
  }
}

}  // namespace
}  // namespace cpplus::bench

int main(int argc, char** argv) {
  using namespace cpplus::bench;
  benchmark::Initialize(&argc, argv);
  for (size_t millions : {1, 10, 50}) {
    register_all({.num_points = millions * 1000000});
    register_all({.num_points = millions * 1000000, .sparse = true});
  }
  register_all({.num_points = 10000000, .shuffled = true});
  register_lookups({.num_points = 10000000});
  register_lookups({.num_points = 10000000, .sparse = true});
  benchmark::RunSpecifiedBenchmarks();
}
