#include "cpplus/pipeline/upright_check.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cpplus {
namespace {

constexpr double kLyingDeg = 60.0;
constexpr double kUprightDeg = 30.0;

double median_tilt_deg(const Eigen::Quaterniond& camera_from_sensor, const std::vector<Rigid3>& map_from_sensor,
                       const Eigen::Vector3d& up_in_map) {
  const Eigen::Vector3d down_in_sensor = camera_from_sensor.conjugate() * Eigen::Vector3d::UnitY();
  std::vector<double> tilts;
  for (const Rigid3& pose : map_from_sensor) {
    const double cosine = -(pose.rotation * down_in_sensor).dot(up_in_map.normalized());
    tilts.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / M_PI);
  }
  const auto middle = tilts.begin() + static_cast<std::ptrdiff_t>(tilts.size() / 2);
  std::nth_element(tilts.begin(), middle, tilts.end());
  return *middle;
}

/// What the rotation should be if a mistake was made.
std::vector<std::pair<std::string, Eigen::Quaterniond>> usual_mistakes(const Eigen::Quaterniond& q) {
  const Eigen::Quaterniond was_w_last(q.z(), q.w(), q.x(), q.y());   // [x y z w] read as w x y z
  const Eigen::Quaterniond was_w_first(q.x(), q.y(), q.z(), q.w());  // [w x y z] read as x y z w
  return {{"inverted", q.conjugate()},
          {"given with w last where w is read first", was_w_last},
          {"given with w first where w is read last", was_w_first},
          {"inverted, with w last where w is read first", was_w_last.conjugate()},
          {"inverted, with w first where w is read last", was_w_first.conjugate()}};
}

}  // namespace

UprightCheck check_upright(const Rigid3& camera_from_sensor, const std::vector<Rigid3>& map_from_sensor,
                           const Eigen::Vector3d& up_in_map) {
  UprightCheck check;
  if (map_from_sensor.empty()) return check;
  check.tilt_deg = median_tilt_deg(camera_from_sensor.rotation, map_from_sensor, up_in_map);
  if (check.tilt_deg < kLyingDeg) return check;
  for (const auto& [mistake, rotation] : usual_mistakes(camera_from_sensor.rotation)) {
    const double tilt_deg = median_tilt_deg(rotation, map_from_sensor, up_in_map);
    if (tilt_deg > kUprightDeg) continue;
    check.mistake = mistake;  // the simplest one that explains it
    check.corrected_tilt_deg = tilt_deg;
    break;
  }
  return check;
}

}  // namespace cpplus
