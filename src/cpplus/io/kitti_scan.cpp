#include "cpplus/io/kitti_scan.h"

#include <fmt/format.h>

#include <array>
#include <cstring>

#include "cpplus/core/error.h"
#include "cpplus/io/block_reader.h"

namespace cpplus {

PointCloud read_kitti_scan(const std::string& path) {
  using Record = std::array<float, 4>;
  BlockReader reader(path);
  if (reader.file_size() % sizeof(Record) != 0) {
    throw Error(fmt::format("{}: {} bytes are no whole number of points of {} bytes", path, reader.file_size(),
                            sizeof(Record)));
  }
  PointCloud cloud;
  while (reader.remaining() > 0) {
    Record record;
    std::memcpy(record.data(), reader.take(sizeof(Record)), sizeof(Record));
    const Eigen::Vector3f position(record[0], record[1], record[2]);
    if (!position.allFinite()) continue;
    cloud.positions.push_back(position);
    cloud.intensities.push_back(record[3]);
  }
  if (cloud.empty()) throw Error(fmt::format("{}: holds no points", path));
  return cloud;
}

}  // namespace cpplus
