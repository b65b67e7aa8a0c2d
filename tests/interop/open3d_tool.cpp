// Writes the known cloud with Open3D, or copies a file through Open3D:
//   open3d_tool write DIR COUNT
//   open3d_tool copy IN OUT

#include <open3d/geometry/PointCloud.h>
#include <open3d/io/PointCloudIO.h>

#include <string>

#include "known_cloud.h"

namespace {

bool save(const std::string& path, const open3d::geometry::PointCloud& cloud, bool ascii, bool compressed) {
  return open3d::io::WritePointCloud(path, cloud, open3d::io::WritePointCloudOption(ascii, compressed));
}

}  // namespace

int main(int argc, char** argv) {
  const std::string verb = argc > 1 ? argv[1] : "";
  if (verb == "write" && argc == 4) {
    const std::string folder = argv[2];
    const int count = std::stoi(argv[3]);
    open3d::geometry::PointCloud cloud;
    for (int i = 0; i < count; ++i) {
      const auto xyz = interop::position(i);
      const auto rgb = interop::color(i);
      cloud.points_.emplace_back(xyz[0], xyz[1], xyz[2]);
      cloud.colors_.emplace_back(rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0);
    }
    const bool saved =
        save(folder + "/ascii.pcd", cloud, true, false) && save(folder + "/binary.pcd", cloud, false, false) &&
        save(folder + "/compressed.pcd", cloud, false, true) && save(folder + "/ascii.ply", cloud, true, false) &&
        save(folder + "/binary.ply", cloud, false, false);
    return saved ? 0 : 1;
  }
  if (verb == "copy" && argc == 4) {
    open3d::geometry::PointCloud cloud;
    if (!open3d::io::ReadPointCloud(argv[2], cloud)) return 1;
    return save(argv[3], cloud, false, false) ? 0 : 1;
  }
  return 2;
}
