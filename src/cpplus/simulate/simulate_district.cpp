#include "cpplus/simulate/simulate_district.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cpplus/core/error.h"
#include "cpplus/core/interrupt.h"
#include "cpplus/core/progress.h"
#include "cpplus/simulate/district_plan.h"
#include "cpplus/simulate/district_tile.h"
#include "cpplus/simulate/district_window.h"
#include "cpplus/simulate/hash.h"
#include "cpplus/simulate/map_displacement.h"
#include "cpplus/simulate/path.h"
#include "cpplus/simulate/recording.h"

namespace cpplus {
namespace {

constexpr double kMillion = 1e6;
constexpr double kPointsPerKm2 = 400e6;  // some scans of the default LiDAR in 10 m of street
constexpr double kImageReach = 100.0;    // metres; beyond, streets may end in the sky
constexpr double kMapFitReach = 25.0;    // metres of way

/// When scans are taken: as many and evenly spread as it takes to come to a number of points. How many points a scan
/// has is only known once it is taken.
class ScanSchedule {
 public:
  ScanSchedule(double num_points, double duration_s) : num_points_(num_points), duration_s_(duration_s) {}

  /// Infinite after the last scan.
  double next_stamp_s() const { return next_s_; }

  /// The next scan was taken and has this many points.
  void taken(size_t points) {
    taken_points_ += static_cast<double>(points);
    ++num_scans_;
    const double mean = std::max(1.0, taken_points_ / num_scans_);
    const double scans_left = (num_points_ - taken_points_) / mean;
    next_s_ = scans_left < 0.5 ? std::numeric_limits<double>::infinity()
                               : next_s_ + (duration_s_ - next_s_) / std::max(1.0, scans_left);
    if (next_s_ >= duration_s_) next_s_ = std::numeric_limits<double>::infinity();
  }

 private:
  double num_points_;
  double duration_s_;
  double next_s_ = 0.0;
  double taken_points_ = 0.0;
  double num_scans_ = 0.0;
};

/// The scan's points where the map has them.
PointCloud in_map(const SimulatedScan& scan) {
  PointCloud points;
  points.positions.reserve(scan.scan.points.size());
  for (size_t i = 0; i < scan.scan.points.size(); ++i) {
    points.positions.push_back((scan.map_from_lidar * scan.scan.points.point(i)).cast<float>());
  }
  points.intensities = scan.scan.points.intensities;
  return points;
}

class DistrictRecorder {
 public:
  DistrictRecorder(const SimulateOptions& options, const DistrictPlan& plan, const DistrictSink& sink)
      : options_(options),
        sink_(sink),
        surroundings_(district_surroundings(plan)),
        path_(surroundings_.way),
        camera_(simulated_camera(options)),
        lidar_from_camera_(simulated_extrinsic(static_cast<uint64_t>(options.seed))),
        window_(plan, surroundings_, std::max(kImageReach, options.lidar.max_range_m)),
        renderer_(window_.tracer(), window_.light(), camera_, path_, lidar_from_camera_, options.render),
        shots_(plan_shots(path_.duration_s(), options)) {
    for (const Shot& shot : shots_) {
      SimulatedImage image;
      image.stamp_s = shot.stamp_s;
      image.camera_from_map = renderer_.camera_from_map(shot.stamp_s);
      images_.push_back(std::move(image));
    }
  }

  SimulatedWorld record() {
    const double num_points =
        options_.points_million > 0.0 ? options_.points_million * kMillion : options_.area_km2 * kPointsPerKm2;
    ScanSchedule schedule(num_points, path_.duration_s());
    MapDisplacement displacement(camera_, images_, kMapFitReach / surroundings_.way.speed_mps);
    const StatedPoses stated(options_);
    Progress progress("record", static_cast<size_t>(std::ceil(path_.duration_s())));
    size_t next_image = 0;
    double now_s = 0.0;
    while (true) {
      check_interrupt();
      const double image_s =
          next_image < shots_.size() ? shots_[next_image].stamp_s : std::numeric_limits<double>::infinity();
      const double next_s = std::min(schedule.next_stamp_s(), image_s);
      if (std::isinf(next_s)) break;
      progress.advance(static_cast<size_t>(next_s) - static_cast<size_t>(now_s));
      now_s = next_s;
      window_.move_to(path_.map_from_lidar(now_s).translation.head<2>());
      if (image_s <= schedule.next_stamp_s()) {
        take_next_image(next_image++);
      } else {
        const SimulatedScan scan = take_scan(now_s, stated);
        displacement.add(scan, window_.tracer());
        schedule.taken(scan.scan.points.size());
      }
    }
    return finish(displacement.finish());
  }

 private:
  void take_next_image(size_t index) {
    SimulatedImage image = take_image(renderer_, shots_[index], index);
    sink_.image(image);
    image.pixels = {};
    image.range = {};
    images_[index] = std::move(image);
  }

  SimulatedScan take_scan(double stamp_s, const StatedPoses& stated) {
    SimulatedScan scan;
    scan.stamp_s = stamp_s;
    scan.true_map_from_lidar = path_.map_from_lidar(stamp_s);
    scan.map_from_lidar = stated.at(stamp_s, scan.true_map_from_lidar);
    scans_.push_back(scan);
    scan.scan = fire_scan(window_.tracer(), scan.true_map_from_lidar, stamp_s, static_cast<int>(scans_.size() - 1),
                          hash_seed(static_cast<uint64_t>(options_.seed), 0x11), options_.lidar);
    sink_.scan(in_map(scan));
    return scan;
  }

  SimulatedWorld finish(const std::vector<Rigid3>& on_map) {
    SimulatedWorld world;
    world.camera = camera_;
    world.lidar_from_camera = lidar_from_camera_;
    world.scans = std::move(scans_);
    world.coarse = coarse_levels(path_, lidar_from_camera_, stamps_of(images_), static_cast<uint64_t>(options_.seed));
    for (size_t i = 0; i < on_map.size(); ++i) images_[i].on_map_camera_from_map = on_map[i];
    world.images = std::move(images_);
    world.scene = std::move(surroundings_);
    return world;
  }

  SimulateOptions options_;
  DistrictSink sink_;
  Scene surroundings_;
  Path path_;
  Camera camera_;
  Rigid3 lidar_from_camera_;
  DistrictWindow window_;
  Renderer renderer_;
  std::vector<Shot> shots_;
  std::vector<SimulatedImage> images_;  // without pixels and ranges
  std::vector<SimulatedScan> scans_;    // without points
};

}  // namespace

SimulatedWorld simulate_district(const SimulateOptions& options, const DistrictSink& sink) {
  options.validate();
  const DistrictPlan plan = plan_district(options.area_km2, static_cast<uint64_t>(options.seed));
  return DistrictRecorder(options, plan, sink).record();
}

}  // namespace cpplus
