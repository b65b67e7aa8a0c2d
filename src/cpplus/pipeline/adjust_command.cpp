#include "cpplus/pipeline/adjust_command.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cpplus/core/error.h"
#include "cpplus/core/options.h"
#include "cpplus/core/version.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/trajectory_io.h"
#include "cpplus/pipeline/cloud_output.h"
#include "cpplus/pipeline/scan_folder.h"

namespace cpplus {
namespace {

using nlohmann::ordered_json;

ordered_json array_of(const Eigen::VectorXd& values) {
  ordered_json array = ordered_json::array();
  for (const double value : values) array.push_back(value);
  return array;
}

ordered_json scan_json(const std::string& file, const ScanAdjustment& scan) {
  ordered_json json;
  json["name"] = std::filesystem::path(file).filename().string();
  json["patches"] = scan.num_patches;
  json["correction"] = array_of(scan.correction);
  json["sigma"] = array_of(scan.sigma);
  json["weak_directions"] = ordered_json::array();
  for (const WeakDirection& weak : scan.weak_directions)
    json["weak_directions"].push_back({{"direction", array_of(weak.direction)}, {"sigma_m", weak.sigma_m}});
  return json;
}

std::string report_text(const ScanFolder& folder, const AdjustResult& result) {
  const ThicknessChange& thickness = result.thickness;
  ordered_json json;
  json["version"] = version();
  json["status"] = status_name(result.status);
  json["iterations"] = result.iterations;
  json["converged"] = result.has_converged;
  json["patches"] = result.num_patches;
  json["held_out"] = {{"patches", thickness.num_patches},
                      {"thickness_before_m", thickness.before_m},
                      {"thickness_after_m", thickness.after_m},
                      {"thickness_single_scan_m", thickness.single_scan_m},
                      {"gain", thickness.gain},
                      {"gain_sigma", thickness.gain_sigma}};
  json["scans"] = ordered_json::array();
  for (size_t i = 0; i < folder.files.size(); ++i) json["scans"].push_back(scan_json(folder.files[i], result.scans[i]));
  return json.dump(1) + "\n";
}

}  // namespace

std::string adjust_report_path(const std::string& out) {
  return std::filesystem::path(out).replace_extension(".json").string();
}

void AdjustCommandOptions::validate() const {
  require_option("scans", scans);
  require_option("poses", poses);
  require_option("out", out);
  if (adjust_report_path(out) == out) throw UsageError(fmt::format("option out must not end in .json, got {}", out));
  adjust.validate();
}

AdjustResult run_adjust(const AdjustCommandOptions& options) {
  options.validate();
  if (!options.map.empty()) check_cloud_output(options.map);
  ScanFolder folder = read_scan_folder(options.scans, options.poses);
  std::vector<Rigid3> input;
  for (const StampedPose& pose : folder.map_from_lidar) input.push_back(pose.map_from_sensor);
  const AdjustResult result = adjust_scans(folder.scans, input, options.adjust);

  if (!options.map.empty()) {
    move_scans(input, result.map_from_lidar, &folder.scans);
    write_point_cloud(options.map, folder.scans.points);
  }
  write_text_file(adjust_report_path(options.out), report_text(folder, result));
  for (size_t i = 0; i < input.size(); ++i) folder.map_from_lidar[i].map_from_sensor = result.map_from_lidar[i];
  write_tum(options.out, folder.map_from_lidar);
  return result;
}

}  // namespace cpplus
