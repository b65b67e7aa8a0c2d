#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "cpplus/pipeline/evaluate_command.h"

namespace cpplus {
namespace {

// Keys stay in the order they are written; NaN becomes null.
using Json = nlohmann::ordered_json;

Json json_of(const SampleStatistics& statistics) {
  return {{"count", statistics.count},
          {"mean", statistics.mean},
          {"median", statistics.median},
          {"rms", statistics.rms},
          {"max", statistics.max}};
}

Json json_of(const TrajectoryError& error) {
  return {{"translation_m", json_of(error.translation_m)}, {"rotation_deg", json_of(error.rotation_deg)}};
}

Json json_of(const ImageComparison& image) {
  return {{"name", image.name},
          {"rotation_deg", image.pose.rotation_deg},
          {"translation_m", image.pose.translation_m},
          {"num_points", image.shift.num_points},
          {"num_lost_points", image.shift.num_lost},
          {"mean_shift_px", image.shift.mean_px},
          {"median_shift_px", image.shift.median_px},
          {"max_shift_px", image.shift.max_px},
          {"checkerboard_residual_px", image.checkerboard_px}};
}

std::string number(double value, const char* format) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), value);
}

std::string statistics_line(const char* label, const SampleStatistics& statistics) {
  if (statistics.count == 0) return "";
  return fmt::format("{:<26}{:>6}{:>12.4f}{:>12.4f}{:>12.4f}{:>12.4f}\n", label, statistics.count, statistics.median,
                     statistics.mean, statistics.rms, statistics.max);
}

std::string error_lines(const std::string& label, const TrajectoryError& error) {
  return statistics_line((label + " m").c_str(), error.translation_m) +
         statistics_line((label + " deg").c_str(), error.rotation_deg);
}

}  // namespace

std::string comparison_json(const ModelComparison& comparison) {
  Json images = Json::array();
  for (const ImageComparison& image : comparison.images) images.push_back(json_of(image));
  Json shares = Json::object();
  for (size_t k = 0; k < kSuccessThresholdsPx.size(); ++k) {
    shares[fmt::format("under_{:.0f}_px", kSuccessThresholdsPx[k])] = comparison.shift_shares[k];
  }
  Json absolute = Json::object();
  for (const auto& [alignment, error] : comparison.absolute) {
    absolute[trajectory_alignment_name(alignment)] = error ? json_of(*error) : Json();
  }
  Json relative = Json::array();
  for (const auto& [length_m, error] : comparison.relative) {
    relative.push_back(json_of(error));
    relative.back()["length_m"] = length_m;
  }
  const Json document = {{"summary",
                          {{"rotation_deg", json_of(comparison.rotation_deg)},
                           {"translation_m", json_of(comparison.translation_m)},
                           {"shift_px", json_of(comparison.shift_px)},
                           {"shift_shares", shares},
                           {"checkerboard_residual_px", json_of(comparison.checkerboard_px)}}},
                         {"absolute", absolute},
                         {"relative", relative},
                         {"only_in_estimate", comparison.only_in_estimate},
                         {"only_in_reference", comparison.only_in_reference},
                         {"images", images}};
  return document.dump(2) + "\n";
}

std::string comparison_table(const ModelComparison& comparison) {
  std::string text = fmt::format("{:<26}{:>12}{:>12}{:>12}{:>12}{:>12}\n", "image", "rotation", "translation", "shift",
                                 "shift", "board");
  text += fmt::format("{:<26}{:>12}{:>12}{:>12}{:>12}{:>12}\n", "", "deg", "m", "mean px", "median px", "px");
  for (const ImageComparison& image : comparison.images) {
    text += fmt::format("{:<26}{:>12.4f}{:>12.4f}{:>12}{:>12}{:>12}\n", image.name, image.pose.rotation_deg,
                        image.pose.translation_m, number(image.shift.mean_px, "{:.3f}"),
                        number(image.shift.median_px, "{:.3f}"), number(image.checkerboard_px, "{:.3f}"));
  }
  text += fmt::format("\n{:<26}{:>6}{:>12}{:>12}{:>12}{:>12}\n", "over the images", "count", "median", "mean", "rms",
                      "max");
  text += statistics_line("rotation deg", comparison.rotation_deg);
  text += statistics_line("translation m", comparison.translation_m);
  text += statistics_line("mean shift px", comparison.shift_px);
  text += statistics_line("board residual px", comparison.checkerboard_px);
  for (const auto& [alignment, error] : comparison.absolute) {
    if (error) text += error_lines(fmt::format("ATE {}", trajectory_alignment_name(alignment)), *error);
  }
  for (const auto& [length_m, error] : comparison.relative) {
    text += error_lines(length_m > 0.0 ? fmt::format("RPE {:.2f} m", length_m) : "RPE next image", error);
  }
  if (comparison.shift_px.count > 0) {
    text += "\nimages with a mean shift";
    for (size_t k = 0; k < kSuccessThresholdsPx.size(); ++k) {
      text += fmt::format("{} < {:.0f} px: {:.0f} %", k == 0 ? "" : ",", kSuccessThresholdsPx[k],
                          100.0 * comparison.shift_shares[k]);
    }
    text += "\n";
  }
  if (!comparison.only_in_estimate.empty() || !comparison.only_in_reference.empty()) {
    text += fmt::format("not compared: {} images only in the estimate, {} only in the reference\n",
                        comparison.only_in_estimate.size(), comparison.only_in_reference.size());
  }
  return text;
}

}  // namespace cpplus
