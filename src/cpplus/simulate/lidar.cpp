#include "cpplus/simulate/lidar.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"
#include "cpplus/simulate/hash.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kDegToRad = M_PI / 180.0;
constexpr size_t kBeamsPerTask = 4096;

struct Echo {
  bool valid = false;
  double range = 0.0;
  double intensity = 0.0;
  bool moving = false;
};

/// Share of the light that a surface sends straight back: its albedo, falling off with incidence.
double returned_light(const TraceHit& hit, const Vector3f& direction) {
  const Material& material = *hit.material;
  const double cosine = std::max(0.0, static_cast<double>(-hit.normal.dot(direction)));
  const double grey = albedo(material, hit.uv, 0.01f).dot(Vector3f(0.5f, 0.35f, 0.15f));  // red side of the spectrum
  return std::min(1.0, material.lidar_reflectance * grey) * (0.25 + 0.75 * cosine);
}

/// A beam as a few rays: its axis and, with divergence, four on a circle that holds half of a uniform beam's light.
struct Bundle {
  std::array<Vector3f, 5> rays;
  size_t count = 1;
};

Bundle make_bundle(const Vector3f& axis, double divergence_mrad) {
  Bundle bundle;
  bundle.rays[0] = axis;
  if (divergence_mrad <= 0.0) return bundle;
  const auto offset = static_cast<float>(0.5e-3 * divergence_mrad * std::sqrt(0.5));
  const Vector3f helper = std::abs(axis.z()) < 0.9f ? Vector3f::UnitZ() : Vector3f::UnitX();
  const Vector3f across = helper.cross(axis).normalized();
  const Vector3f up = axis.cross(across);
  for (const Vector3f& side : {across, up, Vector3f(-across), Vector3f(-up)}) {
    bundle.rays[bundle.count++] = (axis + offset * side).normalized();
  }
  return bundle;
}

/// The strongest echo of a bundle of rays.
Echo strongest_echo(const Tracer& tracer, const BodyPoses& bodies, const Vector3f& origin, const Bundle& bundle,
                    double echo_length_m) {
  struct Return {
    double range = 0.0;
    double light = 0.0;
    bool moving = false;
  };
  std::array<Return, 5> returns;
  size_t count = 0;
  for (size_t i = 0; i < bundle.count; ++i) {
    const auto hit = tracer.trace(origin, bundle.rays[i], bodies);
    if (!hit) continue;
    // Kept in the order of the range.
    size_t place = count++;
    for (; place > 0 && returns[place - 1].range > hit->range; --place) returns[place] = returns[place - 1];
    returns[place] = {hit->range, returned_light(*hit, bundle.rays[i]), hit->body >= 0};
  }
  Echo best;
  size_t best_count = 0;
  for (size_t begin = 0; begin < count;) {
    size_t end = begin + 1;
    while (end < count && returns[end].range - returns[end - 1].range < echo_length_m) ++end;
    if (end - begin > best_count) {
      best_count = end - begin;
      best = Echo{};
      best.valid = true;
      size_t moving = 0;
      for (size_t i = begin; i < end; ++i) {
        best.range += returns[i].range / static_cast<double>(best_count);
        best.intensity += returns[i].light / static_cast<double>(bundle.count);
        moving += returns[i].moving ? 1 : 0;
      }
      best.moving = 2 * moving > best_count;
    }
    begin = end;
  }
  return best;
}

}  // namespace

void LidarOptions::validate() const {
  if (pattern != "spinning" && pattern != "solid_state") {
    throw UsageError("option pattern must be spinning or solid_state, got " + pattern);
  }
  check_option(rings >= 1 && rings <= 1024, "rings", "[1, 1024]", rings);
  check_option(azimuth_steps >= 8 && azimuth_steps <= 36000, "azimuth_steps", "[8, 36000]", azimuth_steps);
  check_option(lowest_deg > -90.0 && lowest_deg < 90.0, "lowest_deg", "(-90, 90)", lowest_deg);
  check_option(highest_deg >= lowest_deg && highest_deg < 90.0, "highest_deg", "[lowest_deg, 90)", highest_deg);
  check_option(beams >= 1 && beams <= 10000000, "beams", "[1, 10000000]", beams);
  check_option(cone_deg > 0.0 && cone_deg <= 170.0, "cone_deg", "(0, 170]", cone_deg);
  check_option(range_noise_m >= 0.0 && range_noise_m <= 1.0, "range_noise_m", "[0, 1]", range_noise_m);
  check_option(divergence_mrad >= 0.0 && divergence_mrad <= 50.0, "divergence_mrad", "[0, 50]", divergence_mrad);
  check_option(echo_length_m >= 0.0 && echo_length_m <= 10.0, "echo_length_m", "[0, 10]", echo_length_m);
  check_option(min_range_m >= 0.0, "min_range_m", "[0, inf)", min_range_m);
  check_option(max_range_m > min_range_m, "max_range_m", "(min_range_m, inf)", max_range_m);
}

std::vector<Vector3d> beam_directions(const LidarOptions& options, int scan) {
  std::vector<Vector3d> directions;
  if (options.pattern == "spinning") {
    directions.reserve(static_cast<size_t>(options.rings) * static_cast<size_t>(options.azimuth_steps));
    for (int step = 0; step < options.azimuth_steps; ++step) {
      const double azimuth = 2.0 * M_PI * step / options.azimuth_steps;
      for (int ring = 0; ring < options.rings; ++ring) {
        const double share = options.rings > 1 ? static_cast<double>(ring) / (options.rings - 1) : 0.5;
        const double elevation = kDegToRad * (options.lowest_deg + share * (options.highest_deg - options.lowest_deg));
        directions.emplace_back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                std::sin(elevation));
      }
    }
    return directions;
  }
  constexpr double kBeamsPerPetal = 160.0;
  const double turn_per_petal = M_PI * (1.0 + 1.0 / (4.0 + 0.5 * (1.0 + std::sqrt(5.0))));
  for (int i = 0; i < options.beams; ++i) {
    const double petal = (static_cast<double>(scan) * options.beams + i) / kBeamsPerPetal;
    const double radius = 0.5 * kDegToRad * options.cone_deg * std::sin(M_PI * petal);
    const double angle = turn_per_petal * petal;
    directions.emplace_back(std::cos(radius), std::sin(radius) * std::cos(angle), std::sin(radius) * std::sin(angle));
  }
  return directions;
}

LidarScan fire_scan(const Tracer& tracer, const Rigid3& map_from_lidar, double stamp_s, int scan, uint64_t seed,
                    const LidarOptions& options) {
  const std::vector<Vector3d> directions = beam_directions(options, scan);
  const BodyPoses bodies = body_poses(tracer.scene(), stamp_s);
  const Vector3f origin = map_from_lidar.translation.cast<float>();
  std::vector<Echo> echoes(directions.size());
  parallel_for_chunks(directions.size(), kBeamsPerTask, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Vector3f axis = (map_from_lidar.rotation * directions[i]).cast<float>();
      Echo echo =
          strongest_echo(tracer, bodies, origin, make_bundle(axis, options.divergence_mrad), options.echo_length_m);
      Random random(hash_seed(seed, static_cast<uint64_t>(scan), i));
      echo.range += options.range_noise_m * random.normal();
      echo.intensity = std::clamp(255.0 * echo.intensity * (1.0 + 0.04 * random.normal()), 0.0, 255.0);
      echo.valid = echo.valid && echo.range >= options.min_range_m && echo.range <= options.max_range_m;
      echoes[i] = echo;
    }
  });
  LidarScan result;
  for (size_t i = 0; i < echoes.size(); ++i) {
    if (!echoes[i].valid) continue;
    result.points.positions.push_back((echoes[i].range * directions[i]).cast<float>());
    result.points.intensities.push_back(static_cast<float>(echoes[i].intensity));
    result.labels.push_back(echoes[i].moving ? 1 : 0);
  }
  return result;
}

}  // namespace cpplus
