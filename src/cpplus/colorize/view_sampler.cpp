#include "cpplus/colorize/view_sampler.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "cpplus/core/error.h"
#include "cpplus/core/options.h"

namespace cpplus {
namespace {

constexpr double kMinCosIncidence = 0.15;
constexpr double kUnknownCosIncidence = 0.5;
/// What is left of the weight at the corners of the image, and on the rim of a foreground.
constexpr double kCornerWeight = 0.25;
constexpr double kRimWeight = 0.2;

}  // namespace

void ViewSamplingOptions::validate() const {
  check_option(max_distance_m > 0, "max_distance_m", "(0, inf)", max_distance_m);
  check_option(border_margin_px >= 0, "border_margin_px", "[0, inf)", border_margin_px);
  check_option(occlusion_tolerance_m > 0, "occlusion_tolerance_m", "(0, inf)", occlusion_tolerance_m);
  check_option(edge_margin_px >= 0, "edge_margin_px", "[0, inf)", edge_margin_px);
  check_option(edge_jump_ratio >= 0, "edge_jump_ratio", "[0, inf)", edge_jump_ratio);
  check_option(reference_distance_m > 0, "reference_distance_m", "(0, inf)", reference_distance_m);
}

Rgb bilinear(const ColorImage& image, const Eigen::Vector2d& pixel) {
  const auto x = static_cast<float>(std::clamp(pixel.x(), 0.0, image.width - 1.0));
  const auto y = static_cast<float>(std::clamp(pixel.y(), 0.0, image.height - 1.0));
  const int x0 = std::min(static_cast<int>(x), std::max(0, image.width - 2));
  const int y0 = std::min(static_cast<int>(y), std::max(0, image.height - 2));
  const int x1 = std::min(x0 + 1, image.width - 1);
  const int y1 = std::min(y0 + 1, image.height - 1);
  const float right = x - static_cast<float>(x0);
  const float down = y - static_cast<float>(y0);
  const Rgb &top_left = image.at(x0, y0), &top_right = image.at(x1, y0);
  const Rgb &bottom_left = image.at(x0, y1), &bottom_right = image.at(x1, y1);
  Rgb color;
  for (size_t c = 0; c < 3; ++c) {
    const float top = static_cast<float>(top_left[c]) + right * static_cast<float>(top_right[c] - top_left[c]);
    const float bottom =
        static_cast<float>(bottom_left[c]) + right * static_cast<float>(bottom_right[c] - bottom_left[c]);
    color[c] = static_cast<uint8_t>(top + down * (bottom - top) + 0.5f);
  }
  return color;
}

ViewSampler::ViewSampler(const ColorView& view, const std::vector<Eigen::Vector3f>& bearings,
                         const ViewSamplingOptions& options)
    : view_(view),
      options_(options),
      bearings_(bearings),
      image_center_(0.5 * (view.camera.width() - 1), 0.5 * (view.camera.height() - 1)),
      radius_per_px_(view.camera.model() == CameraModel::kEquirectangular ? 0.0
                                                                          : 1.0 / std::max(1.0, image_center_.norm())),
      reach_cells_(static_cast<int>(std::ceil(options.edge_margin_px / view.depth.cell_px))) {
  assert(bearings.size() == view.depth.range.pixels.size());
  if (view.image.width != view.camera.width() || view.image.height != view.camera.height()) {
    throw Error(fmt::format("image {}: {} x {} pixels, but its camera has {} x {}", view.name, view.image.width,
                            view.image.height, view.camera.width(), view.camera.height()));
  }
  find_surroundings();
}

/// First along the rows, then along the columns.
void ViewSampler::find_surroundings() {
  const RangeImage& range = view_.depth.range;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  RangeImage nearest(range.width, range.height, kInfinity), farthest(range.width, range.height);
  for (int y = 0; y < range.height; ++y) {
    for (int x = 0; x < range.width; ++x) {
      for (int column = x - reach_cells_; column <= x + reach_cells_; ++column) {
        const int other = view_.depth.column(column);
        if (other < 0) continue;
        const float there = range.at(other, y) > 0.0f ? range.at(other, y) : kInfinity;
        nearest.at(x, y) = std::min(nearest.at(x, y), there);
        farthest.at(x, y) = std::max(farthest.at(x, y), there);
      }
    }
  }
  surroundings_ = Image<Surroundings>(range.width, range.height);
  RangeImage nearest_of_row(range.width, 1), farthest_of_row(range.width, 1);
  for (int y = 0; y < range.height; ++y) {
    std::fill(nearest_of_row.pixels.begin(), nearest_of_row.pixels.end(), kInfinity);
    std::fill(farthest_of_row.pixels.begin(), farthest_of_row.pixels.end(), 0.0f);
    for (int row = std::max(0, y - reach_cells_); row <= std::min(range.height - 1, y + reach_cells_); ++row) {
      for (int x = 0; x < range.width; ++x) {
        nearest_of_row.at(x, 0) = std::min(nearest_of_row.at(x, 0), nearest.at(x, row));
        farthest_of_row.at(x, 0) = std::max(farthest_of_row.at(x, 0), farthest.at(x, row));
      }
    }
    for (int x = 0; x < range.width; ++x) {
      surroundings_.at(x, y) = {range.at(x, y), nearest_of_row.at(x, 0), farthest_of_row.at(x, 0)};
    }
  }
}

std::optional<ViewSample> ViewSampler::sample(const Eigen::Vector3d& x_in_camera,
                                              const Eigen::Vector3d& normal_in_camera) const {
  const double range = x_in_camera.norm();
  if (range > options_.max_distance_m || range == 0.0) return {};
  const auto pixel = view_.camera.project(x_in_camera);
  // A panorama has no border to the left and the right.
  const bool has_border = view_.camera.model() != CameraModel::kEquirectangular;
  if (!pixel || !view_.camera.in_image(*pixel, has_border ? options_.border_margin_px : -0.5)) return {};

  const bool has_normal = !normal_in_camera.isZero();
  const double cos_incidence = has_normal
                                   ? std::max(kMinCosIncidence, std::abs(normal_in_camera.dot(x_in_camera)) / range)
                                   : kUnknownCosIncidence;
  const double slack_m = options_.occlusion_tolerance_m / cos_incidence;
  const Eigen::Vector2i cell = view_.depth.cell_of(*pixel);
  const float nearest = surroundings_.contains(cell.x(), cell.y()) ? surroundings_.at(cell.x(), cell.y()).range : 0.0f;
  if (nearest > 0.0f && range > nearest + slack_m) return {};
  const Neighborhood around = look_around(cell, x_in_camera, range, normal_in_camera, slack_m);
  if (around == Neighborhood::kHidden) return {};

  const double nearness = range / options_.reference_distance_m;
  const double radius = radius_of(*pixel);
  const double position_weight = 1.0 - (1.0 - kCornerWeight) * radius * radius;
  const double weight = view_.weight * cos_incidence / (1.0 + nearness * nearness) * position_weight *
                        (around == Neighborhood::kRim ? kRimWeight : 1.0);
  return ViewSample{bilinear(view_.image, *pixel), weight, radius};
}

ViewSampler::Neighborhood ViewSampler::look_around(const Eigen::Vector2i& cell, const Eigen::Vector3d& x_in_camera,
                                                   double range, const Eigen::Vector3d& normal_in_camera,
                                                   double slack_m) const {
  const RangeImage& buffer = view_.depth.range;
  const double jump_m = slack_m + options_.edge_jump_ratio * range;
  if (surroundings_.contains(cell.x(), cell.y())) {
    const Surroundings& around = surroundings_.at(cell.x(), cell.y());
    if (range - around.nearest <= jump_m && around.farthest - range <= jump_m) return Neighborhood::kPlain;
  }
  const double plane_distance = normal_in_camera.dot(x_in_camera);
  Neighborhood result = Neighborhood::kPlain;
  for (int y = std::max(0, cell.y() - reach_cells_); y <= std::min(buffer.height - 1, cell.y() + reach_cells_); ++y) {
    for (int column = cell.x() - reach_cells_; column <= cell.x() + reach_cells_; ++column) {
      const int x = view_.depth.column(column);
      if (x < 0) continue;
      const float there = buffer.at(x, y);
      if (there > 0.0f && std::abs(there - range) <= jump_m) continue;
      // Where the point's own surface continues to in that direction: a floor seen at a grazing angle is no edge.
      const size_t index = static_cast<size_t>(y) * static_cast<size_t>(buffer.width) + static_cast<size_t>(x);
      const double slope = normal_in_camera.dot(bearings_[index].cast<double>());
      const double continued = slope * plane_distance > 0.0 ? plane_distance / slope : range;
      if (there > 0.0f && there < std::min(range, continued) - jump_m) return Neighborhood::kHidden;
      if (there == 0.0f || there > std::max(range, continued) + jump_m) result = Neighborhood::kRim;
    }
  }
  return result;
}

double ViewSampler::radius_of(const Eigen::Vector2d& pixel) const {
  return std::min(1.0, radius_per_px_ * (pixel - image_center_).norm());
}

}  // namespace cpplus
