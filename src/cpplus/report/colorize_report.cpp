#include "cpplus/report/colorize_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace cpplus {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json difference_json(const ImageDifference& difference) {
  const bool any = difference.num_covered > 0;
  return {{"psnr_db", any ? number(psnr_db(difference.mean_square)) : Json(nullptr)},
          {"matched_psnr_db", any ? number(psnr_db(difference.matched_mean_square)) : Json(nullptr)},
          {"covered", static_cast<double>(difference.num_covered) /
                          static_cast<double>(std::max<size_t>(1, difference.num_pixels))}};
}

Json held_out_json(const std::vector<HeldOutImage>& held_out) {
  if (held_out.empty()) return nullptr;
  Json json = difference_json(total_difference(held_out));
  json["images"] = Json::array();
  for (const HeldOutImage& image : held_out) {
    Json entry = {{"name", image.name}};
    entry.update(difference_json(image.difference));
    entry["scale"] = image.difference.scale;
    entry["blurred"] = image.blurred;
    json["images"].push_back(entry);
  }
  return json;
}

}  // namespace

ImageDifference total_difference(const std::vector<HeldOutImage>& images) {
  ImageDifference total;
  for (const HeldOutImage& image : images) {
    if (image.blurred) continue;
    const auto covered = static_cast<double>(image.difference.num_covered);
    total.num_pixels += image.difference.num_pixels;
    total.num_covered += image.difference.num_covered;
    total.mean_square += covered * image.difference.mean_square;
    total.matched_mean_square += covered * image.difference.matched_mean_square;
  }
  if (total.num_covered == 0) return total;
  total.mean_square /= static_cast<double>(total.num_covered);
  total.matched_mean_square /= static_cast<double>(total.num_covered);
  return total;
}

std::string colorize_report_json(const ColorizeResult& result, const std::vector<HeldOutImage>& held_out) {
  Json json;
  json["images"] = Json::array();
  for (const ColorizedImage& image : result.images) {
    json["images"].push_back({{"name", image.name},
                              {"id", image.image_id},
                              {"camera", image.camera_id},
                              {"gain", std::exp(image.exposure.log_gain)},
                              {"determined", image.exposure.determined}});
  }
  json["cameras"] = Json::array();
  for (const auto& [id, vignetting] : result.vignetting) {
    json["cameras"].push_back({{"id", id},
                               {"vignetting", vignetting.coefficients},
                               {"corner_brightness", std::exp(log_vignetting(vignetting.coefficients, 1.0))},
                               {"determined", vignetting.determined}});
  }
  json["exposure_residual"] = result.exposure_residual;
  json["held_out"] = held_out_json(held_out);
  return json.dump(2) + "\n";
}

}  // namespace cpplus
