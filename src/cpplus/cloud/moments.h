#pragma once

#include <Eigen/Core>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Running count, mean and covariance of points, accumulated about a point near them so that nothing cancels.
class Moments {
 public:
  explicit Moments(const Eigen::Vector3d& reference) : reference_(reference) {}

  void add(const Eigen::Vector3d& x) {
    const Eigen::Vector3d d = x - reference_;
    ++count_;
    sum_ += d;
    sum_of_squares_.noalias() += d * d.transpose();
  }

  void add(const VoxelStatistics& voxel) {
    const Eigen::Vector3d d = voxel.mean - reference_;
    const double n = static_cast<double>(voxel.count);
    count_ += voxel.count;
    sum_ += n * d;
    sum_of_squares_ += n * (voxel.covariance + d * d.transpose());
  }

  size_t count() const { return count_; }
  Eigen::Vector3d mean() const { return reference_ + sum_ / static_cast<double>(count_); }
  /// Divided by the count, square metres.
  Eigen::Matrix3d covariance() const {
    const Eigen::Vector3d d = sum_ / static_cast<double>(count_);
    return sum_of_squares_ / static_cast<double>(count_) - d * d.transpose();
  }

 private:
  Eigen::Vector3d reference_;
  size_t count_ = 0;
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d sum_of_squares_ = Eigen::Matrix3d::Zero();
};

}  // namespace cpplus
