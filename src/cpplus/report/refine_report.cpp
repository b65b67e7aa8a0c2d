#include "cpplus/report/refine_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "cpplus/core/version.h"

namespace cpplus {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no NaN and no infinity.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json residual_json(const EdgeResidual& residual) {
  Json json;
  json["median_px"] = number(residual.median_px);
  json["rms_px"] = number(residual.rms_px);
  json["inlier_share"] = number(residual.inlier_share);
  json["log_ratio"] = number(residual.log_ratio);
  json["samples"] = residual.num_samples;
  json["matches"] = residual.num_matches;
  return json;
}

template <typename Matrix>
Json matrix_json(const Matrix& matrix) {
  Json rows = Json::array();
  for (int r = 0; r < matrix.rows(); ++r) {
    Json row = Json::array();
    for (int c = 0; c < matrix.cols(); ++c) row.push_back(number(matrix(r, c)));
    rows.push_back(row);
  }
  return rows;
}

Json patch_residual_json(const PatchResidual& residual) {
  return {{"matches", residual.num_matches},
          {"before_median_px", number(residual.before_median_px)},
          {"after_median_px", number(residual.after_median_px)}};
}

Json milliseconds_json(const ImageReport& image) {
  Json json = Json::object();
  double total = 0.0;
  for (const auto& [stage, milliseconds] : image.milliseconds) {
    json[stage] = json.value(stage, 0.0) + milliseconds;
    total += milliseconds;
  }
  json["total"] = number(total);
  return json;
}

Json image_json(const ImageReport& image) {
  const RefinePoseResult& r = image.refine;
  Json json;
  json["name"] = image.name;
  json["status"] = status_name(image.status);
  json["reason"] = image.reason;
  json["before"] = residual_json(r.before);
  json["after"] = residual_json(r.after);
  json["held_out_before"] = residual_json(r.held_out_before);
  json["held_out_after"] = residual_json(r.held_out_after);
  json["map_edges"] = image.num_map_edges;
  json["samples"] = r.num_samples;
  json["matches"] = r.num_matches;
  json["matched_edges"] = r.num_edges;
  json["iterations"] = r.iterations;
  json["sharpness"] = number(image.sharpness);
  json["milliseconds"] = milliseconds_json(image);
  json["covariance"] = matrix_json(r.covariance);
  json["eigenvalues"] = matrix_json(Eigen::Matrix<double, 1, 6>(r.information_eigenvalues.transpose()))[0];
  json["weak_directions"] = r.weak_directions;
  json["surfaces"] = patch_residual_json(image.surfaces);
  json["intensities"] = patch_residual_json(image.intensities);
  json["predicted_shift_px"] = number(r.predicted_shift_px);
  if (image.nid) {
    json["nid"] = {{"before", number(image.nid->before)},
                   {"after", number(image.nid->after)},
                   {"points", image.nid->num_points},
                   {"evaluations", image.nid->evaluations}};
  }
  return json;
}

Json shared_json(const SharedErrors& shared) {
  Json json;
  json["images"] = shared.num_images;
  json["time_offset_s"] = number(shared.time_offset_s);
  json["time_offset_sigma_s"] = number(shared.time_offset_sigma_s);
  json["extrinsic"] = matrix_json(Eigen::Matrix<double, 1, 6>(shared.extrinsic.transpose()))[0];
  json["extrinsic_sigmas"] = matrix_json(Eigen::Matrix<double, 1, 6>(shared.extrinsic_sigmas.transpose()))[0];
  if (shared.readout) {
    json["readout_s"] = number(shared.readout->value);
    json["readout_sigma_s"] = number(shared.readout->sigma);
  }
  if (shared.range_scale) {
    json["range_scale"] = number(shared.range_scale->value);
    json["range_scale_sigma"] = number(shared.range_scale->sigma);
  }
  for (const Estimate& parameter : shared.intrinsics) {
    json["intrinsics_changes"].push_back(number(parameter.value));
    json["intrinsics_sigmas"].push_back(number(parameter.sigma));
  }
  json["undetermined"] = shared.undetermined;
  return json;
}

Json option_json(const OptionField& field) {
  return std::visit([](const auto* value) { return Json(*value); }, field.value);
}

}  // namespace

std::string status_name(ImageStatus status) {
  switch (status) {
    case ImageStatus::kRefined:
      return "refined";
    case ImageStatus::kKeptCoarse:
      return "kept_coarse";
    case ImageStatus::kBlurred:
      return "blurred";
    case ImageStatus::kOutsideMap:
      return "outside_map";
    case ImageStatus::kUnreadable:
      return "unreadable";
  }
  return "";
}

std::string refine_report_json(const RefineInputs& inputs, const MapReport& map,
                               const std::map<uint32_t, SharedErrors>& shared, const std::vector<ImageReport>& images,
                               const std::vector<OptionField>& options) {
  Json json;
  json["version"] = version();
  json["inputs"] = {{"map", inputs.map}, {"images", inputs.images}, {"poses", inputs.poses}};
  json["options"] = Json::object();
  for (const OptionField& field : options) json["options"][field.path] = option_json(field);
  json["map"] = {{"path", map.path},         {"points", map.num_points}, {"dropped_points", map.num_dropped_points},
                 {"planes", map.num_planes}, {"edges", map.num_edges},   {"noise_m", number(map.noise_m)}};
  json["shared"] = Json::object();
  for (const auto& [camera, errors] : shared) json["shared"][std::to_string(camera)] = shared_json(errors);
  json["images"] = Json::array();
  for (const ImageReport& image : images) json["images"].push_back(image_json(image));
  return json.dump(1) + "\n";
}

}  // namespace cpplus
