#include "cpplus/pipeline/clean_command.h"

#include <fmt/format.h>

#include <limits>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/core/memory.h"
#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/pipeline/cloud_output.h"
#include "cpplus/pipeline/scan_folder.h"

namespace cpplus {

namespace {

constexpr size_t kPointsPerTask = 1 << 16;

template <typename T>
void keep_static(const std::vector<uint8_t>& labels, std::vector<T>* values) {
  if (values->empty()) return;
  size_t kept = 0;
  for (size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] == 0) (*values)[kept++] = (*values)[i];
  }
  values->resize(kept);
}

/// The positions that a map was made of; those that it dropped come back as not a number.
std::vector<Eigen::Vector3f> positions_in_input_order(const VoxelMap& map) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  std::vector<Eigen::Vector3f> positions(map.num_points() + map.num_dropped(), Eigen::Vector3f::Constant(kNan));
  parallel_for_chunks(map.num_points(), kPointsPerTask, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) positions[map.input_index(i)] = map.positions()[i];
  });
  return positions;
}

}  // namespace

void CleanCommandOptions::validate() const {
  require_option("scans", scans);
  require_option("poses", poses);
  require_option("out", out);
  voxel_map.validate();
  dynamics.validate();
}

CleanSummary run_clean(const CleanCommandOptions& options) {
  options.validate();
  check_cloud_output(options.out);
  ScanFolder folder = read_scan_folder(options.scans, options.poses);
  PointCloud& points = folder.scans.points;
  DynamicsResult dynamics;
  {
    const VoxelMap map(points, options.voxel_map);
    free_memory(&points.positions);  // the map holds them
    return_freed_memory();           // and what building the map took
    dynamics = find_dynamics(map, folder.scans, options.dynamics);
    points.positions = positions_in_input_order(map);
  }
  const CleanSummary summary{folder.files.size(), points.size(), dynamics.num_dynamic};
  if (summary.num_dynamic == summary.num_points) throw Error(fmt::format("{}: no point is static", options.scans));
  if (!options.labels.empty()) write_label_files(options.labels, folder, dynamics.labels);
  keep_static(dynamics.labels, &points.positions);
  keep_static(dynamics.labels, &points.intensities);
  keep_static(dynamics.labels, &points.colors);
  keep_static(dynamics.labels, &points.stamps_s);
  write_point_cloud(options.out, points);
  return summary;
}

}  // namespace cpplus
