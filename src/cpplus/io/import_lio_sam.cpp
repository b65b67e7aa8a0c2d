#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/io/import_files.h"
#include "cpplus/io/imported_project.h"
#include "cpplus/io/pcd_columns.h"

namespace cpplus {

ImportedProject import_lio_sam(const std::string& folder) {
  ImportedProject project;
  const std::string path = required_file(folder, "transformations.pcd");
  const std::vector<std::vector<double>> v = read_pcd_columns(path, {"x", "y", "z", "roll", "pitch", "yaw", "time"});
  std::vector<StampedPose> poses;
  for (size_t i = 0; i < v[0].size(); ++i) {
    // Its angles are those of pcl::getTransformation: roll about x first, yaw about z last.
    const Eigen::Quaterniond rotation = Eigen::AngleAxisd(v[5][i], Eigen::Vector3d::UnitZ()) *
                                        Eigen::AngleAxisd(v[4][i], Eigen::Vector3d::UnitY()) *
                                        Eigen::AngleAxisd(v[3][i], Eigen::Vector3d::UnitX());
    const Eigen::Vector3d translation(v[0][i], v[1][i], v[2][i]);
    if (!rotation.coeffs().allFinite() || !translation.allFinite() || !std::isfinite(v[6][i])) {
      throw Error(fmt::format("{}: pose {} is not finite", path, i));
    }
    poses.push_back({v[6][i], Rigid3(rotation, translation)});
  }
  const OrderedTrajectory ordered = order_by_stamp(poses);
  if (ordered.trajectory.empty()) throw Error(fmt::format("{}: holds no poses", path));
  if (ordered.num_double > 0) {
    project.notes.push_back(
        fmt::format("{}: {} of {} poses with the stamp of another, left out; an ascii file keeps too few digits", path,
                    ordered.num_double, poses.size()));
  }
  project.trajectory = ordered.trajectory;
  project.map = first_file(folder, {"GlobalMap.pcd", "cloudGlobal.pcd"});
  if (project.map.empty())
    project.notes.push_back(fmt::format("{}: neither GlobalMap.pcd nor cloudGlobal.pcd", folder));
  return project;
}

ImportedProject import_r3live(const std::string& folder) {
  ImportedProject project;
  project.map = required_file(folder, "rgb_pt.pcd");
  project.notes.push_back(fmt::format("{}: R3LIVE saves neither images nor poses as files that others read", folder));
  return project;
}

}  // namespace cpplus
