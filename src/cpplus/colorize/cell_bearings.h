#pragma once

#include <Eigen/Core>
#include <list>
#include <vector>

#include "cpplus/cloud/depth_buffer.h"

namespace cpplus {

/// The viewing rays of the cells of depth buffers. They are costly for a distorted camera and the same for all its
/// images, so those of the last few cameras are kept.
class CellBearings {
 public:
  /// Unit bearings (camera frame) of the centres of the cells, by row; zero where the camera has none. Valid until the
  /// next call.
  const std::vector<Eigen::Vector3f>& of(const DepthBuffer& buffer);

 private:
  struct Grid {
    DepthBuffer empty;  // without ranges
    int width = 0;
    int height = 0;
    std::vector<Eigen::Vector3f> bearings;

    bool has_cells_of(const DepthBuffer& buffer) const;
  };
  std::list<Grid> grids_;  // the latest first
};

}  // namespace cpplus
