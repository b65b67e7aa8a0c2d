#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/simulate/tracer.h"

namespace cpplus {

struct LidarOptions {
  /// "spinning" (rings around the vertical) or "solid_state" (a rosette about the x axis that does not repeat).
  std::string pattern = "spinning";
  /// Spinning: number of rings. [1, 1024]
  int rings = 32;
  /// Spinning: beams of a turn. [8, 36000]
  int azimuth_steps = 1800;
  /// Spinning: lowest and highest ring, degrees. (-90, 90)
  double lowest_deg = -30.0;
  double highest_deg = 30.0;
  /// Solid state: beams of a scan. [1, 10000000]
  int beams = 50000;
  /// Solid state: full opening of the cone, degrees. (0, 170]
  double cone_deg = 70.4;
  /// Standard deviation of the range, metres. [0, 1]
  double range_noise_m = 0.02;
  /// Full angle of the beam, milliradians: surfaces that share a beam are mixed. 0 = no mixing. [0, 50]
  double divergence_mrad = 3.0;
  /// Echoes nearer together than this merge into one, metres. [0, 10]
  double echo_length_m = 0.6;
  /// Returns outside are dropped, metres.
  double min_range_m = 0.4;
  double max_range_m = 100.0;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("pattern", pattern, "spinning or solid_state.");
    visitor("rings", rings, "Spinning: number of rings. [1, 1024]");
    visitor("azimuth_steps", azimuth_steps, "Spinning: beams of a turn. [8, 36000]");
    visitor("lowest_deg", lowest_deg, "Spinning: elevation of the lowest ring, degrees. (-90, 90)");
    visitor("highest_deg", highest_deg, "Spinning: elevation of the highest ring, degrees. (-90, 90)");
    visitor("beams", beams, "Solid state: beams of a scan. [1, 10000000]");
    visitor("cone_deg", cone_deg, "Solid state: full opening of the cone, degrees. (0, 170]");
    visitor("range_noise_m", range_noise_m, "Standard deviation of the range, metres. [0, 1]");
    visitor("divergence_mrad", divergence_mrad, "Full angle of the beam, milliradians; 0 = no mixed pixels. [0, 50]");
    visitor("echo_length_m", echo_length_m, "Echoes nearer together than this merge into one, metres. [0, 10]");
    visitor("min_range_m", min_range_m, "Nearer returns are dropped, metres. [0, inf)");
    visitor("max_range_m", max_range_m, "Farther returns are dropped, metres. (min_range_m, inf)");
  }
};

struct LidarScan {
  PointCloud points;            // LiDAR frame (x forward, y left, z up), intensity 0..255
  std::vector<uint8_t> labels;  // 0 static, 1 moving body
};

/// Beam directions of scan number `scan`, unit, LiDAR frame. Solid state: the rosette r = |sin(a t)|, angle = b t with
/// an irrational a : b, continued from scan to scan.
std::vector<Eigen::Vector3d> beam_directions(const LidarOptions& options, int scan);

/// Fires one scan from a pose (motion within the scan is taken as compensated). Each beam is a bundle of five rays; the
/// echo with most of them is returned, at the mean of its ranges: what makes mixed pixels at the borders of things.
LidarScan fire_scan(const Tracer& tracer, const Rigid3& map_from_lidar, double stamp_s, int scan, uint64_t seed,
                    const LidarOptions& options);

}  // namespace cpplus
