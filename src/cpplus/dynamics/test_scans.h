#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <vector>

#include "cpplus/core/random.h"
#include "cpplus/cloud/scan_set.h"

namespace cpplus {

/// A scanner in a world of boxes (map frame), for scans whose every point is known to belong to one of them.
struct BoxScanner {
  double step_deg = 1.0;  // between beams, both ways
  double lowest_deg = -30.0;
  double highest_deg = 30.0;
  double noise_m = 0.01;

  /// Appends a scan and, by point, the index of the box that was hit.
  void scan(const std::vector<Eigen::AlignedBox3d>& boxes, const Eigen::Vector3d& sensor, ScanSet* scans,
            std::vector<size_t>* box_of_point) const {
    Random random(scans->num_scans() + 1);
    constexpr double kDegree = M_PI / 180.0;
    for (double azimuth = 0.0; azimuth < 360.0; azimuth += step_deg) {
      for (double elevation = lowest_deg; elevation <= highest_deg; elevation += step_deg) {
        const Eigen::Vector3d direction(std::cos(elevation * kDegree) * std::cos(azimuth * kDegree),
                                        std::cos(elevation * kDegree) * std::sin(azimuth * kDegree),
                                        std::sin(elevation * kDegree));
        double range = std::numeric_limits<double>::infinity();
        size_t hit = 0;
        for (size_t box = 0; box < boxes.size(); ++box) {
          const double distance = range_to(boxes[box], sensor, direction);
          if (distance < range) {
            range = distance;
            hit = box;
          }
        }
        if (!std::isfinite(range)) continue;
        const Eigen::Vector3d point = sensor + (range + noise_m * random.normal()) * direction;
        scans->points.positions.push_back(point.cast<float>());
        box_of_point->push_back(hit);
      }
    }
    scans->first_point.push_back(scans->points.size());
    scans->sensors_in_map.push_back(sensor);
  }

 private:
  static double range_to(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& sensor,
                         const Eigen::Vector3d& direction) {
    const Eigen::Array3d one = (box.min() - sensor).array() / direction.array();
    const Eigen::Array3d other = (box.max() - sensor).array() / direction.array();
    const double enter = one.min(other).maxCoeff();
    const double leave = one.max(other).minCoeff();
    return enter > 0.0 && enter <= leave ? enter : std::numeric_limits<double>::infinity();
  }
};

}  // namespace cpplus
