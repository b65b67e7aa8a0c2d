#include "cpplus/report/report_page.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

using Json = nlohmann::ordered_json;

// Figures of report.json that the page shows as they are.
constexpr const char* kKeptKeys[] = {"name",
                                     "status",
                                     "reason",
                                     "before",
                                     "after",
                                     "held_out_before",
                                     "held_out_after",
                                     "map_edges",
                                     "samples",
                                     "matches",
                                     "iterations",
                                     "sharpness",
                                     "weak_directions",
                                     "surfaces",
                                     "predicted_shift_px"};

Json rounded(const Eigen::Vector2d& v, double step) {
  return {std::round(v.x() / step) * step, std::round(v.y() / step) * step};
}

Json pair_json(const Eigen::Vector2d& v) { return rounded(v, 1e-4); }

// One standard deviation of the camera's place in the top view; null where the report has no covariance.
Json ellipse_json(const Json& covariance, const Rigid3& camera_from_map, const TopView& view) {
  Eigen::Matrix3d in_camera;
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) {
      const Json& value = covariance.at(r + 3).at(c + 3);
      if (value.is_null()) return nullptr;
      in_camera(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = value.get<double>();
    }
  }
  if (in_camera.trace() <= 0.0) return nullptr;
  Eigen::Matrix<double, 2, 3> top_from_map;
  top_from_map << view.right.transpose(), view.ahead.transpose();
  const Eigen::Matrix<double, 2, 3> top_from_camera =
      top_from_map * camera_from_map.rotation.conjugate().toRotationMatrix();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(top_from_camera * in_camera *
                                                              top_from_camera.transpose());
  const Eigen::Vector2d major = solver.eigenvectors().col(1);
  return {std::sqrt(std::max(0.0, solver.eigenvalues()[1])), std::sqrt(std::max(0.0, solver.eigenvalues()[0])),
          std::atan2(major.y(), major.x())};
}

std::map<std::string, const PosedImage*> by_name(const SparseModel& model) {
  std::map<std::string, const PosedImage*> images;
  for (const PosedImage& image : model.images) images[image.name] = &image;
  return images;
}

void add_pose(const Rigid3& coarse, const Rigid3& refined, const TopView& view, const Json& covariance, Json* json) {
  const Vector6d moved = camera_difference(coarse, refined);
  (*json)["at_before"] = pair_json(view * camera_center(coarse));
  (*json)["at_after"] = pair_json(view * camera_center(refined));
  (*json)["looks"] = pair_json(view * (refined.rotation.conjugate() * Eigen::Vector3d::UnitZ()));
  (*json)["ellipse"] = ellipse_json(covariance, refined, view);
  (*json)["moved_m"] = moved.tail<3>().norm();
  (*json)["moved_deg"] = moved.head<3>().norm() * 180.0 / std::numbers::pi;
}

Json image_json(const Json& report, const PosedImage* coarse, const PosedImage* refined, const TopView& view) {
  Json json;
  for (const char* key : kKeptKeys) json[key] = report.at(key);
  json["milliseconds"] = report.at("milliseconds").at("total");
  if (coarse) {
    json["camera"] = coarse->camera_id;
    const Rigid3& after = refined ? refined->camera_from_map : coarse->camera_from_map;
    add_pose(coarse->camera_from_map, after, view, report.at("covariance"), &json);
  }
  return json;
}

Json page_json(const ReportPage& page) {
  const Json report = Json::parse(page.report_json);
  const auto coarse = by_name(page.coarse);
  const auto refined = by_name(page.refined);
  const auto find = [](const std::map<std::string, const PosedImage*>& images, const std::string& name) {
    const auto found = images.find(name);
    return found == images.end() ? nullptr : found->second;
  };
  Json json;
  json["title"] = page.title;
  for (const char* key : {"version", "options", "map", "shared"}) json[key] = report.at(key);
  json["floor_plan"] = nullptr;
  if (page.has_floor_plan) {
    json["floor_plan"] = {{"min", pair_json(page.floor_plan_bounds.min)},
                          {"max", pair_json(page.floor_plan_bounds.max)}};
  }
  json["images"] = Json::array();
  for (size_t i = 0; i < report.at("images").size(); ++i) {
    const Json& image = report.at("images")[i];
    const std::string name = image.at("name");
    json["images"].push_back(image_json(image, find(coarse, name), find(refined, name), page.view));
    if (i >= page.has_pictures.size() || !page.has_pictures[i]) continue;
    const PicturePaths paths = picture_paths(i);
    json["images"].back()["pictures"] = {paths.thumbnail, paths.before, paths.after};
  }
  return json;
}

}  // namespace

PicturePaths picture_paths(size_t image) {
  const auto path = [image](const char* what) { return fmt::format("pictures/{:06}_{}.jpg", image, what); };
  return {path("thumbnail"), path("before"), path("after")};
}

std::string report_page_script(const ReportPage& page) {
  try {
    return "window.cpplusReport = " + page_json(page).dump() + ";\n";
  } catch (const nlohmann::json::exception& error) {
    throw Error(fmt::format("report.json of {}: {}", page.title, error.what()));
  }
}

}  // namespace cpplus
