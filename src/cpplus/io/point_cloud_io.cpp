#include "cpplus/io/point_cloud_io.h"

#include <fmt/format.h>

#include <filesystem>

#include "cpplus/core/error.h"
#include "cpplus/io/cloud_source.h"
#include "cpplus/io/las.h"
#include "cpplus/io/pcd.h"
#include "cpplus/io/ply.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

[[noreturn]] void throw_unknown_extension(const std::string& path) {
  throw Error(fmt::format("{}: unknown point cloud extension {}: known are .pcd, .ply and .las", path,
                          in_quotes(std::filesystem::path(path).extension().string())));
}

void check_lengths(const std::string& path, const PointCloud& cloud) {
  const auto check = [&](const char* name, size_t size) {
    if (size == 0 || size == cloud.size()) return;
    throw Error(fmt::format("{}: cannot write: {} {} for {} points", path, size, name, cloud.size()));
  };
  check("intensities", cloud.intensities.size());
  check("colors", cloud.colors.size());
  check("stamps", cloud.stamps_s.size());
  check("view counts", cloud.num_views.size());
  check("best images", cloud.best_images.size());
  check("colour spreads", cloud.color_spreads.size());
}

}  // namespace

std::string point_cloud_extension(const std::string& path) {
  const std::string extension = lower_case(std::filesystem::path(path).extension().string());
  return extension == ".pcd" || extension == ".ply" || extension == ".las" ? extension : "";
}

std::unique_ptr<CloudSource> open_point_cloud(const std::string& path) {
  const std::string extension = point_cloud_extension(path);
  if (extension == ".pcd") return open_pcd(path);
  if (extension == ".ply") return open_ply(path);
  if (extension == ".las") return open_las(path);
  throw_unknown_extension(path);
}

PointCloud read_point_cloud(const std::string& path, ReadCounts* counts) {
  const std::unique_ptr<CloudSource> source = open_point_cloud(path);
  CloudBuilder builder(path, source->num_points(), source->fields());
  source->read(source->num_points(), &builder);
  PointCloud cloud = builder.finish(counts);
  cloud.las_frame = source->las_frame();
  return cloud;
}

void write_point_cloud(const std::string& path, const PointCloud& cloud) { write_point_cloud(path, stream_of(cloud)); }

void write_point_cloud(const std::string& path, const CloudStream& cloud) {
  const CloudStream checked = {cloud.num_points, [&](const auto& visit) {
                                 cloud.for_each_block([&](const PointCloud& block) {
                                   check_lengths(path, block);
                                   visit(block);
                                 });
                               }};
  const std::string extension = point_cloud_extension(path);
  if (extension == ".pcd") return write_pcd(path, checked);
  if (extension == ".ply") return write_ply(path, checked);
  if (extension == ".las") return write_las(path, checked);
  throw_unknown_extension(path);
}

}  // namespace cpplus
