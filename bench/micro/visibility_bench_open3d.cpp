#include <benchmark/benchmark.h>
#include <open3d/geometry/PointCloud.h>

#include <algorithm>

#include "visibility_bench_scene.h"

namespace cpplus::bench {
namespace {

void hidden_point_removal(benchmark::State& state, const View& view, bool all_around, double radius_factor) {
  open3d::geometry::PointCloud cloud;
  cloud.points_ = all_around ? view.neighborhood_x_in_camera : view.x_in_camera;
  double max_distance = 0.0;
  for (const Eigen::Vector3d& x : cloud.points_) max_distance = std::max(max_distance, x.norm());
  std::vector<uint32_t> kept;
  for (auto _ : state) {
    const auto [mesh, indices] = cloud.HiddenPointRemoval(Eigen::Vector3d::Zero(), radius_factor * max_distance);
    kept.assign(indices.begin(), indices.end());
  }
  for (uint32_t& i : kept) i = all_around ? view.neighborhood[i] : view.candidates[i];
  VisibilityScore score;
  score.add(view.truth, kept);
  state.counters["voxels"] = static_cast<double>(cloud.points_.size());
  state.counters["recall"] = score.recall();
  state.counters["precision"] = score.precision();
}

}  // namespace

void register_open3d(const View& view) {
  for (const double factor : {1.0, 10.0, 100.0, 1000.0}) {
    for (const bool all_around : {true, false}) {
      const std::string name = std::string("Open3dHiddenPointRemoval/") + (all_around ? "20m" : "image") +
                               "/R/max:" + std::to_string(static_cast<int>(factor));
      benchmark::RegisterBenchmark(name.c_str(), hidden_point_removal, view, all_around, factor)
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace cpplus::bench
