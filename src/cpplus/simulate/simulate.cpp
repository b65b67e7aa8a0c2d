#include "cpplus/simulate/simulate.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "cpplus/core/error.h"
#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"
#include "cpplus/simulate/boards_along_way.h"
#include "cpplus/simulate/hash.h"
#include "cpplus/simulate/map_fit.h"
#include "cpplus/simulate/recording.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

/// How much a standing LiDAR sees from a place: free depth in a cone of 30 degrees, and checkerboards.
double view_score(const Tracer& tracer, const WayPoint& place, double height_m) {
  constexpr double kFarEnough = 8.0;
  constexpr double kHalfCone = 0.52;
  constexpr int kRays = 15;
  const Vector3d eye(place.position.x(), place.position.y(), height_m);
  double score = 0.0;
  for (int i = 0; i < kRays; ++i) {
    const double angle = place.yaw_rad + kHalfCone * (2.0 * i / (kRays - 1) - 1.0);
    const auto hit =
        tracer.trace_static(eye.cast<float>(), Vector3d(std::cos(angle), std::sin(angle), 0.0).cast<float>());
    score += std::min(hit ? static_cast<double>(hit->range) : kFarEnough, kFarEnough) / (kFarEnough * kRays);
  }
  for (const SceneCheckerboard& board : tracer.scene().boards) {
    const Vector3d ray = 0.5 * (board.corners.front() + board.corners.back()) - eye;
    const double turn = std::remainder(std::atan2(ray.y(), ray.x()) - place.yaw_rad, 2.0 * M_PI);
    const auto hit = tracer.trace_static(eye.cast<float>(), ray.normalized().cast<float>());
    const bool seen = hit && hit->range > ray.norm() - 0.05 && hit->normal.dot(ray.cast<float>()) < 0.0f;
    if (seen && std::abs(turn) < 0.8 * kHalfCone) score += 0.5;
  }
  return score;
}

/// For a LiDAR that stands: the camera wanders within arm's reach of it and looks the same way. The place is the one
/// of the way, and the direction the one of eight, that show most.
Way standing_way(const Tracer& tracer, uint64_t seed) {
  constexpr int kDirections = 8;
  constexpr int kPoints = 12;
  Random random(hash_seed(seed, 0x57));
  Way standing = tracer.scene().way;
  WayPoint best = standing.points.front();
  double best_score = -1.0;
  for (WayPoint place : tracer.scene().way.points) {
    for (int i = 0; i < kDirections; ++i) {
      place.yaw_rad += 2.0 * M_PI / kDirections;
      const double score = view_score(tracer, place, standing.lidar_height_m);
      if (score <= best_score) continue;
      best_score = score;
      best = place;
    }
  }
  standing.points.clear();
  for (int i = 0; i < kPoints; ++i) {
    WayPoint point = best;
    point.position += 0.35 * Eigen::Vector2d(std::sin(1.1 * i), std::sin(1.7 * i + 0.4));
    point.yaw_rad += random.uniform(-0.2, 0.2);
    standing.points.push_back(point);
  }
  standing.speed_mps = 0.4;
  return standing;
}

/// Whether a body ever comes so near to the LiDAR that it would walk through it.
bool runs_into(const MovingBody& body, const Path& path) {
  constexpr double kStep = 0.1;
  constexpr double kNear = 0.45;
  for (double time = 0.0; time < path.duration_s(); time += kStep) {
    const Vector3d offset = body.map_from_body(time) * body.pivot - path.map_from_lidar(time).translation;
    if (offset.head<2>().norm() < kNear) return true;
  }
  return false;
}

std::vector<SimulatedScan> take_scans(const Tracer& tracer, const Path& path, const SimulateOptions& options) {
  const auto seed = static_cast<uint64_t>(options.seed);
  const StatedPoses stated(options);
  const std::vector<double> stamps = options.standing
                                         ? spread_stamps(options.scans, options.scans, 0.0, hash_seed(seed, 0x5C))
                                         : spread_stamps(options.scans, path.duration_s(), 0.0, hash_seed(seed, 0x5C));
  std::vector<SimulatedScan> scans;
  for (int i = 0; i < options.scans; ++i) {
    SimulatedScan scan;
    scan.stamp_s = stamps[static_cast<size_t>(i)];
    scan.true_map_from_lidar = path.map_from_lidar(options.standing ? 0.0 : scan.stamp_s);
    scan.map_from_lidar = stated.at(scan.stamp_s, scan.true_map_from_lidar);
    scan.scan = fire_scan(tracer, scan.true_map_from_lidar, scan.stamp_s, i, hash_seed(seed, 0x11), options.lidar);
    scans.push_back(std::move(scan));
  }
  return scans;
}

/// All scans at their stated poses, the first point of each voxel.
void accumulate_map(const std::vector<SimulatedScan>& scans, double voxel_m, SimulatedWorld* world) {
  std::unordered_set<uint64_t> taken;
  for (size_t s = 0; s < scans.size(); ++s) {
    const LidarScan& scan = scans[s].scan;
    for (size_t i = 0; i < scan.points.size(); ++i) {
      const Vector3d point = scans[s].map_from_lidar * scan.points.point(i);
      uint64_t key = 0;
      for (int k = 0; k < 3; ++k) {
        key = (key << 21) | (static_cast<uint64_t>(static_cast<int64_t>(std::floor(point[k] / voxel_m))) & 0x1fffffu);
      }
      if (!taken.insert(key).second) continue;
      world->map.positions.push_back(point.cast<float>());
      world->map.intensities.push_back(scan.points.intensities[i]);
      world->map_labels.push_back(scan.labels[i]);
      world->map_scans.push_back(static_cast<uint32_t>(s));
    }
  }
}

/// Static map points that an image sees, spread evenly over it, with their undisplaced places.
std::vector<DisplacedPoint> seen_points(const Tracer& tracer, const SimulatedWorld& world,
                                        const std::vector<Rigid3>& truth_from_map, const Rigid3& camera_from_map) {
  constexpr int kCellsAcross = 32;
  constexpr int kPerCell = 8;
  constexpr size_t kMaxTried = 60000;
  const Camera& camera = world.camera;
  const double cell = static_cast<double>(camera.width()) / kCellsAcross;
  const int rows = static_cast<int>(std::ceil(camera.height() / cell));
  std::vector<int> taken(static_cast<size_t>(kCellsAcross * rows), 0);
  std::vector<DisplacedPoint> points;
  const Vector3d center = camera_center(camera_from_map);
  const size_t stride = std::max<size_t>(1, world.map.size() / kMaxTried);
  for (size_t i = 0; i < world.map.size(); i += stride) {
    if (world.map_labels[i] != 0) continue;
    const DisplacedPoint point = {truth_from_map[world.map_scans[i]] * world.map.point(i), world.map.point(i)};
    const auto pixel = camera.project(camera_from_map * point.x_in_truth);
    if (!pixel || !camera.in_image(*pixel)) continue;
    int& count = taken[static_cast<size_t>(static_cast<int>(pixel->y() / cell) * kCellsAcross +
                                           static_cast<int>(pixel->x() / cell))];
    if (count >= kPerCell) continue;
    const Vector3d ray = point.x_in_truth - center;
    const double range = ray.norm();
    const double slack = 0.05 + 0.01 * range;
    const auto hit = tracer.trace_static(center.cast<float>(), (ray / range).cast<float>());
    if (!hit || std::abs(hit->range - range) > slack) continue;
    ++count;
    points.push_back(point);
  }
  return points;
}

void take_images(const Tracer& tracer, const Path& path, const SimulateOptions& options, SimulatedWorld* world) {
  const SoftLight light(tracer, world->scene.light_cell_m);
  const Renderer renderer(tracer, light, world->camera, path, world->lidar_from_camera, options.render);
  for (const Shot& shot : plan_shots(path.duration_s(), options)) {
    SimulatedImage image = take_image(renderer, shot, world->images.size());
    for (BoardView& view : find_board_views(tracer, renderer, world->camera, shot, world->images.size())) {
      world->board_views.push_back(std::move(view));
    }
    world->images.push_back(std::move(image));
  }
}

void fit_images_to_map(const Tracer& tracer, SimulatedWorld* world) {
  std::vector<Rigid3> truth_from_map;
  for (const SimulatedScan& scan : world->scans) {
    truth_from_map.push_back(scan.true_map_from_lidar * inverse(scan.map_from_lidar));
  }
  parallel_for_each(world->images.size(), [&](size_t i) {
    SimulatedImage& image = world->images[i];
    image.on_map_camera_from_map = fit_pose_to_map(world->camera, image.camera_from_map,
                                                   seen_points(tracer, *world, truth_from_map, image.camera_from_map));
  });
}

void validate_district(const SimulateOptions& options) {
  const double area = options.area_km2;
  const double points = options.points_million;
  const double range = options.lidar.max_range_m;
  if (area == 0.0) throw UsageError("option area is required for scene district");
  check_option(area >= 0.01 && area <= 16.0, "area", "[0.01, 16]", area);
  check_option(points >= 0.0 && points <= 1e4, "points", "[0, 10000]", points);
  // Every street within reach is in memory.
  check_option(range <= 200.0, "lidar.max_range_m", "(min_range_m, 200] for scene district", range);
  if (options.standing || options.boards > 0) {
    throw UsageError("options standing and boards are not for scene district");
  }
}

}  // namespace

void SimulateOptions::validate() const {
  if (is_district()) {
    validate_district(*this);
  } else if (std::find(scene_names().begin(), scene_names().end(), scene) == scene_names().end()) {
    throw UsageError("option scene must be room, rooms, hall, street, corridor or district, got " + scene);
  } else if (area_km2 != 0.0 || points_million != 0.0) {
    throw UsageError("options area and points are for scene district, got scene " + scene);
  }
  if (camera != "PINHOLE" && camera != "OPENCV" && camera != "OPENCV_FISHEYE" && camera != "EQUIRECTANGULAR") {
    throw UsageError("option camera must be PINHOLE, OPENCV, OPENCV_FISHEYE or EQUIRECTANGULAR, got " + camera);
  }
  check_option(width >= 16 && width <= 16384, "width", "[16, 16384]", width);
  check_option(height >= 16 && height <= 16384, "height", "[16, 16384]", height);
  check_option(images >= 1 && images <= 100000, "images", "[1, 100000]", images);
  check_option(blurred >= 0 && blurred <= images, "blurred", "[0, images]", blurred);
  check_option(boards >= 0 && boards <= 26, "boards", "[0, 26]", boards);
  check_option(scans >= 1 && scans <= 100000, "scans", "[1, 100000]", scans);
  check_option(scan_pose_sigma_m >= 0.0 && scan_pose_sigma_m <= 1.0, "scan_pose_sigma_m", "[0, 1]", scan_pose_sigma_m);
  check_option(scan_pose_sigma_deg >= 0.0 && scan_pose_sigma_deg <= 10.0, "scan_pose_sigma_deg", "[0, 10]",
               scan_pose_sigma_deg);
  check_option(map_voxel_m > 0.0 && map_voxel_m <= 1.0, "map_voxel_m", "(0, 1]", map_voxel_m);
  lidar.validate();
  render.validate();
}

SimulatedWorld simulate_world(const SimulateOptions& options) {
  options.validate();
  if (options.is_district()) throw UsageError("scene district does not fit into memory");
  const auto seed = static_cast<uint64_t>(options.seed);
  SimulatedWorld world;
  world.scene = build_scene(options.scene, seed);
  if (!options.moving) world.scene.bodies.clear();
  add_boards_along_way(options.boards, seed, &world.scene);
  world.camera = simulated_camera(options);
  world.lidar_from_camera = simulated_extrinsic(seed);
  if (options.standing) world.scene.way = standing_way(Tracer(world.scene), seed);
  const Path path(world.scene.way);
  std::erase_if(world.scene.bodies, [&](const MovingBody& body) { return runs_into(body, path); });
  const Tracer tracer(world.scene);

  world.scans = take_scans(tracer, path, options);
  accumulate_map(world.scans, options.map_voxel_m, &world);
  take_images(tracer, path, options, &world);
  fit_images_to_map(tracer, &world);
  world.edges = find_true_edges(tracer);

  world.coarse = coarse_levels(path, world.lidar_from_camera, stamps_of(world.images), seed);
  return world;
}

}  // namespace cpplus
