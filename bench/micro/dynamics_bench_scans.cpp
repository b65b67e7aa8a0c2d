#include "dynamics_bench_scans.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cpplus/core/random.h"

namespace cpplus::bench {

using Eigen::Vector3d;

ScanSet room_scans(const Vector3d& room_m, size_t num_scans, size_t num_beams) {
  Random random(1);
  ScanSet scans;
  for (size_t scan = 0; scan < num_scans; ++scan) {
    const double share = static_cast<double>(scan) / static_cast<double>(num_scans);
    const Vector3d sensor(1.0 + 2.0 / 3.0 * room_m.x() * share, 0.5 * room_m.y(), 1.5);
    for (size_t beam = 0; beam < num_beams; ++beam) {
      const Vector3d direction = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
      double range = std::numeric_limits<double>::infinity();
      for (int a = 0; a < 3; ++a) {
        range = std::min(range, ((direction[a] > 0.0 ? room_m[a] : 0.0) - sensor[a]) / direction[a]);
      }
      const double to_person = 1.5 / direction.x();
      const bool meets_person = to_person > 0.0 && std::abs(to_person * direction.y()) < 0.25;
      if (meets_person) range = std::min(range, to_person);
      scans.points.positions.push_back((sensor + (range + 0.02 * random.normal()) * direction).cast<float>());
    }
    scans.first_point.push_back(scans.points.size());
    scans.sensors_in_map.push_back(sensor);
  }
  return scans;
}

ScanSet hall_scans() { return room_scans({40.0, 30.0, 8.0}, 40, 65536); }

}  // namespace cpplus::bench
