#include "cpplus/colorize/exposure_correction.h"

#include <algorithm>
#include <cmath>

#include "cpplus/colorize/srgb.h"

namespace cpplus {
namespace {

constexpr uint8_t kClipped = 250;
constexpr float kMinLight = 0.005f;  // mean of the channels; about grey level 15
constexpr size_t kMinPointBudget = 20000;
constexpr size_t kPointsPerImage = 400;
/// Noise of an image, grey levels; by the slope of the curve it becomes noise of the log light.
constexpr double kNoiseLevels = 3.0;

bool is_usable(const ColorSample& sample, float light) {
  return *std::max_element(sample.color.begin(), sample.color.end()) < kClipped && light >= kMinLight;
}

float mean_light(const ColorSample& sample) {
  return (light_of_level(sample.color[0]) + light_of_level(sample.color[1]) + light_of_level(sample.color[2])) / 3.0f;
}

/// d log(light) is about 2.2 d level / level: inverse variance in units of that of a bright sample.
float weight_of_light(float light) {
  const double level = static_cast<double>(level_of_light(light));
  const double sigma = 2.2 * kNoiseLevels / level;
  return static_cast<float>(1.0 / (1.0 + 1e3 * sigma * sigma));
}

bool is_candidate(const ColorSamples& samples, size_t point) { return samples.of_point(point).size() >= 2; }

void add_point(std::span<const ColorSample> samples, ExposureObservations* result) {
  const size_t begin = result->observations.size();
  for (const ColorSample& sample : samples) {
    const float light = mean_light(sample);
    if (!is_usable(sample, light)) continue;
    result->observations.push_back(
        {sample.image, std::log(light), static_cast<float>(sample.radius) / 255.0f, weight_of_light(light)});
  }
  if (result->observations.size() < begin + 2) {
    result->observations.resize(begin);
  } else {
    result->point_begin.push_back(result->observations.size());
  }
}

}  // namespace

ExposureChoice::ExposureChoice(size_t num_candidates, size_t num_images)
    : num_candidates_(num_candidates),
      budget_(std::min(num_candidates, std::max(kMinPointBudget, kPointsPerImage * num_images))) {}

bool ExposureChoice::takes(size_t rank) const {
  // Taken are the ranks k num_candidates / budget, rounded down, for k below the budget.
  const size_t k = (rank * budget_ + num_candidates_ - 1) / num_candidates_;
  return k < budget_ && k * num_candidates_ / budget_ == rank;
}

size_t count_exposure_candidates(const ColorSamples& samples, size_t begin, size_t end) {
  size_t count = 0;
  for (size_t point = begin; point < end; ++point) count += is_candidate(samples, point) ? 1 : 0;
  return count;
}

void add_exposure_observations(const ColorSamples& samples, size_t begin, size_t end, size_t first_rank,
                               const ExposureChoice& choice, ExposureObservations* observations) {
  size_t rank = first_rank;
  for (size_t point = begin; point < end; ++point) {
    if (is_candidate(samples, point) && choice.takes(rank++)) add_point(samples.of_point(point), observations);
  }
}

ExposureObservations collect_exposure_observations(const ColorSamples& samples, size_t num_images) {
  const size_t num_points = samples.num_points();
  ExposureObservations result;
  const ExposureChoice choice(count_exposure_candidates(samples, 0, num_points), num_images);
  add_exposure_observations(samples, 0, num_points, 0, choice, &result);
  return result;
}

ExposureCorrection::ExposureCorrection(const ExposureModel& model, const std::vector<uint32_t>& camera_of_image) {
  for (const CameraVignetting& camera : model.cameras) {
    std::array<float, 256>& factors = cameras_.emplace_back();
    for (size_t radius = 0; radius < factors.size(); ++radius) {
      factors[radius] =
          static_cast<float>(std::exp(-log_vignetting(camera.coefficients, static_cast<double>(radius) / 255.0)));
    }
  }
  for (size_t i = 0; i < camera_of_image.size(); ++i) {
    images_.push_back({static_cast<float>(std::exp(-model.images[i].log_gain)), camera_of_image[i]});
    is_changed_.push_back(model.images[i].determined || model.cameras[camera_of_image[i]].determined);
  }
}

WeightedColor ExposureCorrection::corrected(const ColorSample& sample) const {
  WeightedColor result;
  result.weight = static_cast<float>(sample.weight);
  if (!is_changed_[sample.image]) {
    std::copy(sample.color.begin(), sample.color.end(), result.color.begin());
    return result;
  }
  const PerImage& image = images_[sample.image];
  const float factor = image.factor * cameras_[image.camera][sample.radius];
  for (size_t c = 0; c < 3; ++c) result.color[c] = level_of_light(factor * light_of_level(sample.color[c]));
  return result;
}

void apply_vignetting(const VignettingCoefficients& coefficients, ColorImage* picture) {
  const double center_x = 0.5 * (picture->width - 1), center_y = 0.5 * (picture->height - 1);
  const double half_diagonal = std::max(1.0, std::hypot(center_x, center_y));
  for (int y = 0; y < picture->height; ++y) {
    for (int x = 0; x < picture->width; ++x) {
      const double radius = std::hypot(x - center_x, y - center_y) / half_diagonal;
      const auto factor = static_cast<float>(std::exp(log_vignetting(coefficients, radius)));
      for (uint8_t& channel : picture->at(x, y)) {
        channel = static_cast<uint8_t>(level_of_light(factor * light_of_level(channel)) + 0.5f);
      }
    }
  }
}

}  // namespace cpplus
