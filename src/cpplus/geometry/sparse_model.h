#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct PosedImage {
  uint32_t id = 0;
  std::string name;
  uint32_t camera_id = 0;
  Rigid3 camera_from_map;
};

/// A sparse 3D point with its track, as COLMAP keeps it.
struct SparsePoint {
  uint64_t id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // map frame, metres
  Rgb color{};
  double error_px = -1.0;
  struct Observation {
    uint32_t image_id = 0;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  };
  std::vector<Observation> track;
};

/// What a COLMAP model folder holds; world = map frame.
struct SparseModel {
  std::map<uint32_t, Camera> cameras;
  std::vector<PosedImage> images;  // in the order of the file
  std::vector<SparsePoint> points;
};

}  // namespace cpplus
