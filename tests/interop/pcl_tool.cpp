// Writes the known cloud with PCL, or copies a file through PCL:
//   pcl_tool write DIR COUNT
//   pcl_tool copy IN.pcd OUT.pcd      (a PCLPointCloud2, all fields as they are; writes binary_compressed)

#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <limits>
#include <string>

#include "known_cloud.h"

namespace {

template <typename Point>
pcl::PointCloud<Point> make_cloud(int count) {
  pcl::PointCloud<Point> cloud;
  for (int i = 0; i < count; ++i) {
    Point point;
    const auto xyz = interop::position(i);
    point.x = xyz[0];
    point.y = xyz[1];
    point.z = xyz[2];
    if constexpr (pcl::traits::has_intensity<Point>::value) point.intensity = interop::intensity(i);
    if constexpr (pcl::traits::has_color<Point>::value) {
      const auto rgb = interop::color(i);
      point.r = rgb[0];
      point.g = rgb[1];
      point.b = rgb[2];
    }
    cloud.push_back(point);
  }
  return cloud;
}

template <typename Point>
void save(const std::string& stem, int count) {
  const pcl::PointCloud<Point> cloud = make_cloud<Point>(count);
  pcl::io::savePCDFileASCII(stem + "_ascii.pcd", cloud);
  pcl::io::savePCDFileBinary(stem + "_binary.pcd", cloud);
  pcl::io::savePCDFileBinaryCompressed(stem + "_compressed.pcd", cloud);
  pcl::io::savePLYFileASCII(stem + "_ascii.ply", cloud);
  pcl::io::savePLYFileBinary(stem + "_binary.ply", cloud);
}

/// A range image of two rows whose first row has no returns, as organised sensors give it.
void save_organised(const std::string& path, int count) {
  pcl::PointCloud<pcl::PointXYZI> cloud(static_cast<uint32_t>(count), 2);
  for (int i = 0; i < count; ++i) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    cloud.at(i, 0) = pcl::PointXYZI(kNan, kNan, kNan, 0.0f);
    const auto xyz = interop::position(i);
    cloud.at(i, 1) = pcl::PointXYZI(xyz[0], xyz[1], xyz[2], interop::intensity(i));
  }
  cloud.is_dense = false;
  pcl::io::savePCDFileBinaryCompressed(path, cloud);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string verb = argc > 1 ? argv[1] : "";
  if (verb == "write" && argc == 4) {
    const std::string folder = argv[2];
    const int count = std::stoi(argv[3]);
    save<pcl::PointXYZ>(folder + "/xyz", count);
    save<pcl::PointXYZI>(folder + "/xyzi", count);
    save<pcl::PointXYZRGB>(folder + "/xyzrgb", count);
    save<pcl::PointXYZRGBA>(folder + "/xyzrgba", count);
    save<pcl::PointXYZINormal>(folder + "/xyzinormal", count);
    save_organised(folder + "/organised.pcd", count);
    return 0;
  }
  if (verb == "copy" && argc == 4) {
    pcl::PCLPointCloud2 cloud;
    if (pcl::io::loadPCDFile(argv[2], cloud) != 0) return 1;
    pcl::PCDWriter writer;
    return writer.writeBinaryCompressed(argv[3], cloud) == 0 ? 0 : 1;
  }
  return 2;
}
