#include "cpplus/pipeline/cloud_output.h"

#include <fmt/format.h>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/point_cloud_io.h"

namespace cpplus {

void check_cloud_output(const std::string& path) {
  if (point_cloud_extension(path).empty()) {
    throw Error(fmt::format("{}: unknown extension of a point cloud (.pcd .ply .las)", path));
  }
  const AtomicFile probe(path);
}

}  // namespace cpplus
