// The region of interest of one image: the depth buffer and the hidden point removal operator, beside Open3D's on the
// same voxels. Time, recall and precision (leaf_truth.h) of each.
//
// usage: visibility_bench [benchmark options] [SCENE [IMAGE]]     SCENE: a folder with map.pcd and truth/{on_map,depth}
#include "cpplus/visibility/region_of_interest.h"

#include <benchmark/benchmark.h>

#include <cstdio>
#include <fstream>
#include <iterator>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/npz.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/visibility/hidden_point_removal.h"
#include "visibility_bench_scene.h"

namespace cpplus::bench {
namespace {

constexpr double kMaxDistanceM = 20.0;

/// The map's points that did not move, where truth/map.label says which.
PointCloud static_points(const std::string& scene) {
  PointCloud cloud = read_point_cloud(scene + "/map.pcd");
  std::ifstream file(scene + "/truth/map.label", std::ios::binary);
  const std::vector<char> labels{std::istreambuf_iterator<char>(file), {}};
  if (labels.size() != cloud.size()) return cloud;
  PointCloud kept;
  kept.origin = cloud.origin;
  for (size_t i = 0; i < cloud.size(); ++i) {
    if (labels[i] == 0) kept.positions.push_back(cloud.positions[i]);
  }
  return kept;
}

View load_view(const std::string& scene, size_t image_index) {
  const SparseModel model = read_sparse_model(scene + "/truth/on_map");
  const PosedImage& image = model.images.at(image_index);
  View view;
  view.map = VoxelMap(static_points(scene), VoxelMapOptions());
  view.camera = model.cameras.at(image.camera_id);
  view.camera_from_map = image.camera_from_map;
  const std::string stem = image.name.substr(0, image.name.rfind('.'));
  const RangeImage range = read_npz_range(scene + "/truth/depth/" + stem + ".npz");
  view.truth = judge_leaves(view.map, view.camera, view.camera_from_map, range, DepthSampling(), kMaxDistanceM);
  for (uint32_t leaf = 0; leaf < view.truth.size(); ++leaf) {
    const Eigen::Vector3d x_in_camera = view.camera_from_map * view.map.center(view.map.leaf_layer(), leaf);
    if (x_in_camera.norm() > kMaxDistanceM) continue;
    view.neighborhood.push_back(leaf);
    view.neighborhood_x_in_camera.push_back(x_in_camera);
    if (view.truth[leaf] == LeafTruth::kNotJudged) continue;
    view.candidates.push_back(leaf);
    view.x_in_camera.push_back(x_in_camera);
  }
  return view;
}

void report(benchmark::State& state, const View& view, const std::vector<uint32_t>& kept) {
  VisibilityScore score;
  score.add(view.truth, kept);
  state.counters["recall"] = score.recall();
  state.counters["precision"] = score.precision();
}

/// From the map to the visible leaves: selection of roots and projection included.
void find_leaves(benchmark::State& state, const View& view, const VisibilityOptions& options) {
  VisibilityResult result;
  for (auto _ : state) result = find_visible_leaves(view.map, view.camera, view.camera_from_map, options);
  report(state, view, result.leaves);
  state.counters["voxels"] = static_cast<double>(result.num_candidates);
}

/// The operator alone, as Open3D's.
void remove_hidden(benchmark::State& state, const View& view, bool all_around, double radius_factor) {
  const std::vector<Eigen::Vector3d>& points = all_around ? view.neighborhood_x_in_camera : view.x_in_camera;
  std::vector<uint32_t> kept;
  for (auto _ : state) kept = remove_hidden_points(points, radius_factor);
  for (uint32_t& i : kept) i = all_around ? view.neighborhood[i] : view.candidates[i];
  report(state, view, kept);
  state.counters["voxels"] = static_cast<double>(points.size());
}

void register_ours(const View& view) {
  VisibilityOptions options;
  options.fov_widening_deg = 0.0;  // the same voxels for all
  benchmark::RegisterBenchmark("DepthBuffer", find_leaves, view, options)->Unit(benchmark::kMillisecond);
  for (const double factor : {1.0, 10.0, 100.0, 1000.0}) {
    const std::string suffix = "/R/max:" + std::to_string(static_cast<int>(factor));
    for (const bool all_around : {true, false}) {
      const std::string name = std::string("RemoveHiddenPoints/") + (all_around ? "20m" : "image") + suffix;
      benchmark::RegisterBenchmark(name.c_str(), remove_hidden, view, all_around, factor)
          ->Unit(benchmark::kMillisecond);
    }
    options.method = "hidden_points";
    options.radius_factor = factor;
    for (int rings = 0; rings <= 2; ++rings) {
      options.dilation = rings;
      const std::string name = "HiddenPoints" + suffix + "/dilation:" + std::to_string(rings);
      benchmark::RegisterBenchmark(name.c_str(), find_leaves, view, options)->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace
}  // namespace cpplus::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const std::string scene = argc > 1 ? argv[1] : CPPLUS_BENCH_SCENE;
  try {
    cpplus::set_num_threads(1);
    const cpplus::bench::View view = cpplus::bench::load_view(scene, argc > 2 ? std::stoul(argv[2]) : 0);
    cpplus::bench::register_ours(view);
#ifdef CPPLUS_BENCH_OPEN3D
    cpplus::bench::register_open3d(view);
#endif
    benchmark::RunSpecifiedBenchmarks();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "visibility_bench: %s\n", e.what());
    return 1;
  }
  return 0;
}
