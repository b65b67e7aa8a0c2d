#include "cpplus/report/view_page.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

using Json = nlohmann::ordered_json;

// Cells of the grid along the longer side: between its corners the bearings are interpolated.
constexpr int kGridCells = 32;

double rounded(double value, double step) { return std::round(value / step) * step; }

// Row by row from the top left corner of the image to the bottom right one; null where no bearing belongs to a pixel.
Json grid_json(const Camera& camera) {
  const double cell_px = static_cast<double>(std::max(camera.width(), camera.height())) / kGridCells;
  const int columns = std::max(2, static_cast<int>(std::lround(camera.width() / cell_px)) + 1);
  const int rows = std::max(2, static_cast<int>(std::lround(camera.height() / cell_px)) + 1);
  Json bearings = Json::array();
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      // The borders of the image are half a pixel from the centres of its outer pixels.
      const Eigen::Vector2d pixel(static_cast<double>(column) / (columns - 1) * camera.width() - 0.5,
                                  static_cast<double>(row) / (rows - 1) * camera.height() - 0.5);
      const std::optional<Eigen::Vector3d> bearing = camera.unproject(pixel);
      for (int i = 0; i < 3; ++i) bearings.push_back(bearing ? Json(rounded((*bearing)[i], 1e-6)) : Json(nullptr));
    }
  }
  return {{"columns", columns}, {"rows", rows}, {"bearings", bearings}};
}

Json pose_json(const Rigid3& camera_from_map, const Eigen::Vector3d& origin_in_map) {
  const Rigid3 map_from_camera = inverse(camera_from_map);
  const Eigen::Quaterniond& q = map_from_camera.rotation;
  const Eigen::Vector3d x = map_from_camera.translation - origin_in_map;
  Json pose = Json::array();
  for (double value : {q.x(), q.y(), q.z(), q.w()}) pose.push_back(rounded(value, 1e-7));
  for (double value : {x.x(), x.y(), x.z()}) pose.push_back(rounded(value, 1e-5));
  return pose;
}

Json images_json(const ViewPage& page, const Json& report) {
  std::map<std::string, const PosedImage*> coarse, refined;
  for (const PosedImage& image : page.coarse.images) coarse[image.name] = &image;
  for (const PosedImage& image : page.refined.images) refined[image.name] = &image;
  Json images = Json::array();
  for (size_t i = 0; i < report.at("images").size(); ++i) {
    const Json& row = report.at("images")[i];
    const std::string name = row.at("name");
    if (coarse.count(name) == 0) continue;
    const PosedImage& before = *coarse.at(name);
    const PosedImage& after = refined.count(name) ? *refined.at(name) : before;
    images.push_back({{"name", name},
                      {"status", row.at("status")},
                      {"shift", row.at("predicted_shift_px")},
                      {"camera", before.camera_id},
                      {"photo", photo_path(i)},
                      {"coarse", pose_json(before.camera_from_map, page.origin_in_map)},
                      {"refined", pose_json(after.camera_from_map, page.origin_in_map)}});
  }
  return images;
}

Json page_json(const ViewPage& page) {
  const Json report = Json::parse(page.report_json);
  Json json;
  json["title"] = page.title;
  json["points"] = page.num_points;
  json["limit_px"] = report.at("options").value("refine.max_predicted_shift_px", 2.0);
  json["origin"] = {page.origin_in_map.x(), page.origin_in_map.y(), page.origin_in_map.z()};
  json["up"] = {page.up.x(), page.up.y(), page.up.z()};
  json["cameras"] = Json::object();
  for (const auto& [id, camera] : page.coarse.cameras) json["cameras"][std::to_string(id)] = grid_json(camera);
  json["images"] = images_json(page, report);
  return json;
}

}  // namespace

std::string photo_path(size_t image) { return fmt::format("photos/{:06}.jpg", image); }

std::string view_page_script(const ViewPage& page) {
  try {
    return "window.cpplusView = " + page_json(page).dump() + ";\n";
  } catch (const nlohmann::json::exception& error) {
    throw Error(fmt::format("report.json of {}: {}", page.title, error.what()));
  }
}

}  // namespace cpplus
