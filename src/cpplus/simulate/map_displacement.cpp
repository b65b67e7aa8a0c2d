#include "cpplus/simulate/map_displacement.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

constexpr int kScansOfASpan = 64;
constexpr int kCellsAcross = 16;
constexpr size_t kPointsTried = 4000;  // of a scan

/// Points of a scan that an image sees, at most one in each cell of it.
void add_seen_points(const Camera& camera, const Rigid3& camera_from_map, const SimulatedScan& scan,
                     const Tracer& tracer, std::vector<DisplacedPoint>* points) {
  const double cell = static_cast<double>(camera.width()) / kCellsAcross;
  const int rows = static_cast<int>(std::ceil(camera.height() / cell));
  std::vector<char> taken(static_cast<size_t>(kCellsAcross * rows), 0);
  const Vector3d center = camera_center(camera_from_map);
  const size_t stride = std::max<size_t>(1, scan.scan.points.size() / kPointsTried);
  for (size_t i = 0; i < scan.scan.points.size(); i += stride) {
    const Vector3d x_in_lidar = scan.scan.points.point(i);
    const DisplacedPoint point = {scan.true_map_from_lidar * x_in_lidar, scan.map_from_lidar * x_in_lidar};
    const auto pixel = camera.project(camera_from_map * point.x_in_truth);
    if (!pixel || !camera.in_image(*pixel)) continue;
    char& is_taken = taken[static_cast<size_t>(static_cast<int>(pixel->y() / cell) * kCellsAcross +
                                               static_cast<int>(pixel->x() / cell))];
    if (is_taken != 0) continue;
    const Vector3d ray = point.x_in_truth - center;
    const double range = ray.norm();
    const auto hit = tracer.trace_static(center.cast<float>(), (ray / range).cast<float>());
    if (!hit || std::abs(hit->range - range) > 0.05 + 0.01 * range) continue;
    is_taken = 1;
    points->push_back(point);
  }
}

}  // namespace

MapDisplacement::MapDisplacement(const Camera& camera, const std::vector<SimulatedImage>& images, double reach_s)
    : camera_(camera),
      reach_s_(reach_s),
      last_scan_s_(-std::numeric_limits<double>::infinity()),
      points_(images.size()) {
  for (const SimulatedImage& image : images) {
    stamps_s_.push_back(image.stamp_s);
    truth_.push_back(image.camera_from_map);
  }
  fitted_ = truth_;
}

void MapDisplacement::add(const SimulatedScan& scan, const Tracer& tracer) {
  if (scan.stamp_s - last_scan_s_ < 2.0 * reach_s_ / kScansOfASpan) return;
  last_scan_s_ = scan.stamp_s;
  fit_images_before(scan.stamp_s - reach_s_);
  const auto end = std::upper_bound(stamps_s_.begin(), stamps_s_.end(), scan.stamp_s + reach_s_);
  parallel_for_each(static_cast<size_t>(end - stamps_s_.begin()) - first_open_, [&](size_t i) {
    const size_t image = first_open_ + i;
    add_seen_points(camera_, truth_[image], scan, tracer, &points_[image]);
  });
}

std::vector<Rigid3> MapDisplacement::finish() {
  fit_images_before(std::numeric_limits<double>::infinity());
  return fitted_;
}

void MapDisplacement::fit_images_before(double stamp_s) {
  const auto end = std::lower_bound(stamps_s_.begin(), stamps_s_.end(), stamp_s);
  const auto last = static_cast<size_t>(end - stamps_s_.begin());
  if (last <= first_open_) return;
  parallel_for_each(last - first_open_, [&](size_t i) {
    const size_t image = first_open_ + i;
    fitted_[image] = fit_pose_to_map(camera_, truth_[image], points_[image]);
    points_[image] = {};
  });
  first_open_ = last;
}

}  // namespace cpplus
