#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/geometry/trajectory.h"
#include "cpplus/simulate/board_views.h"
#include "cpplus/simulate/coarse_poses.h"
#include "cpplus/simulate/lidar.h"
#include "cpplus/simulate/renderer.h"
#include "cpplus/simulate/scene.h"
#include "cpplus/simulate/true_edges.h"

namespace cpplus {

struct SimulateOptions {
  /// "room", "rooms", "hall", "street", "corridor" or "district".
  std::string scene = "room";
  /// District: its size, km². [0.01, 16]
  double area_km2 = 0.0;
  /// District: about how many points the map has, millions; 0 = 400 a km². [0, 10000]
  double points_million = 0.0;
  /// Chooses everything that is left to chance.
  int seed = 1;
  /// Image size, pixels. [16, 16384]
  int width = 1024;
  int height = 768;
  /// PINHOLE, OPENCV, OPENCV_FISHEYE or EQUIRECTANGULAR.
  std::string camera = "OPENCV";
  /// Number of images. [1, 100000]
  int images = 12;
  /// How many of them a jolt has blurred. [0, images]
  int blurred = 1;
  /// Number of scans; a district has as many as its points take. [1, 100000]
  int scans = 36;
  /// The LiDAR stands where its way shows most; the images are taken within reach of it.
  bool standing = false;
  /// Checkerboards on tripods beside the way, besides those of the scene; fewer where they would add nothing. [0, 26]
  int boards = 0;
  /// People and cars move (where the scene has them).
  bool moving = true;
  /// Error of the scan poses that the map is made with: smooth, standard deviation per axis.
  double scan_pose_sigma_m = 0.005;
  double scan_pose_sigma_deg = 0.03;
  /// The map keeps one point a voxel of this size, metres; that of a district keeps all. (0, 1]
  double map_voxel_m = 0.02;
  LidarOptions lidar;
  RenderOptions render;

  bool is_district() const { return scene == "district"; }
  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("scene", scene, "room, rooms, hall, street, corridor or district.");
    visitor("area", area_km2, "District: its size, km2. [0.01, 16]");
    visitor("points", points_million, "District: about how many million points; 0 = 400 a km2. [0, 10000]");
    visitor("seed", seed, "Chooses everything that is left to chance.");
    visitor("width", width, "Image width, pixels. [16, 16384]");
    visitor("height", height, "Image height, pixels. [16, 16384]");
    visitor("camera", camera, "PINHOLE, OPENCV, OPENCV_FISHEYE or EQUIRECTANGULAR.");
    visitor("images", images, "Number of images. [1, 100000]");
    visitor("blurred", blurred, "How many images a jolt has blurred. [0, images]");
    visitor("scans", scans, "Number of scans; a district has as many as its points take. [1, 100000]");
    visitor("standing", standing, "The LiDAR stands still; the images are taken within arm's reach of it.");
    visitor("boards", boards, "Checkerboards beside the way, besides those of the scene. [0, 26]");
    visitor("moving", moving, "People and cars move, where the scene has them.");
    visitor("scan_pose_sigma_m", scan_pose_sigma_m, "Error of the scan poses, metres per axis. [0, 1]");
    visitor("scan_pose_sigma_deg", scan_pose_sigma_deg, "Error of the scan poses, degrees per axis. [0, 10]");
    visitor("map_voxel_m", map_voxel_m,
            "The map keeps one point a voxel of this size, metres; a district's keeps all. (0, 1]");
    visitor.group("lidar", lidar);
    visitor.group("render", render);
  }
};

struct SimulatedImage {
  std::string name;  // 000000.jpg
  double stamp_s = 0.0;
  Rigid3 camera_from_map;         // true, at the middle of the exposure
  Rigid3 on_map_camera_from_map;  // fits the (slightly displaced) map best
  ColorImage pixels;
  /// True range of the static scene at pixels (4 i + 1.5, 4 j + 1.5); 0 = none.
  RangeImage range;
  double blur_px = 0.0;  // 0 = sharp
  double blur_direction_rad = 0.0;
  bool shows_moving = false;
};

struct SimulatedScan {
  double stamp_s = 0.0;
  LidarScan scan;
  Rigid3 map_from_lidar;  // as an odometry would state it: slightly wrong; the map is made with it
  Rigid3 true_map_from_lidar;
};

struct SimulatedWorld {
  Scene scene;
  Camera camera;
  Rigid3 lidar_from_camera;
  std::vector<SimulatedImage> images;
  std::vector<SimulatedScan> scans;
  PointCloud map;
  std::vector<uint8_t> map_labels;  // 1 = point of a moving body
  std::vector<uint32_t> map_scans;  // scan of each map point
  std::vector<CoarsePoses> coarse;
  std::vector<TrueEdge> edges;         // of the static scene
  std::vector<BoardView> board_views;  // by image, then board
};

/// Builds the scene, walks through it, scans and photographs it. The same options give the same world to the last bit,
/// for any number of threads. Throws UsageError for a district, which does not fit: see simulate_district.h.
SimulatedWorld simulate_world(const SimulateOptions& options);

}  // namespace cpplus
