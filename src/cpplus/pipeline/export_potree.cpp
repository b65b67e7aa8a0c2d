#include "cpplus/pipeline/export_potree.h"

#include "cpplus/cloud/point_octree.h"
#include "cpplus/io/map_io.h"
#include "cpplus/io/potree.h"
#include "cpplus/report/display_colors.h"

namespace cpplus {

ExportSummary export_potree(const ExportCommandOptions& options, const Eigen::Vector3d& origin,
                            const std::filesystem::path& folder) {
  PointCloud cloud = read_map_cloud(options.map);
  cloud.origin -= origin;
  cloud.colors = display_colors(cloud).colors;  // viewers draw points without a colour black
  const PointOctree octree = build_point_octree(cloud, {});
  write_potree(folder.string(), std::filesystem::path(options.map).stem().string(), cloud, octree);
  ExportSummary summary;
  summary.num_points = cloud.size();
  return summary;
}

}  // namespace cpplus
