#include "cpplus/colorize/exposure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "cpplus/colorize/exposure_correction.h"
#include "cpplus/colorize/srgb.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

const std::vector<double> kLogGains = {std::log(0.7), std::log(1.3), 0.1, -0.25, 0.4, 0.05};
// A fall to 64 % and to 80 % at the corner.
const std::vector<VignettingCoefficients> kVignetting = {{-0.3, -0.2, 0.05}, {-0.1, -0.1, -0.02}};
const std::vector<uint32_t> kCameras = {0, 0, 0, 1, 1, 1};

struct World {
  double noise = 0.02;           // of log light
  double outliers = 0.0;         // share of observations that show something else
  bool same_radius = false;      // a point is equally far from the centre in all images
  std::vector<uint32_t> images;  // those that see the points; empty = all
};

void add_points(const World& world, size_t num_points, Random* random, ExposureObservations* result) {
  std::vector<uint32_t> images = world.images;
  if (images.empty()) {
    images.resize(kCameras.size());
    std::iota(images.begin(), images.end(), 0u);
  }
  for (size_t point = 0; point < num_points; ++point) {
    const double brightness = -2.5 + random->uniform() * 2.0;
    const double common_radius = random->uniform();
    for (int view = 0; view < 3; ++view) {
      const uint32_t image =
          images[(point + static_cast<size_t>(view) * (1 + point / images.size() % 2)) % images.size()];
      const double radius = world.same_radius ? common_radius : random->uniform();
      double light = brightness + kLogGains[image] + log_vignetting(kVignetting[kCameras[image]], radius) +
                     world.noise * random->normal();
      if (random->uniform() < world.outliers) light = -4.0 + 4.0 * random->uniform();
      result->observations.push_back({image, static_cast<float>(light), static_cast<float>(radius), 1.0f});
    }
    result->point_begin.push_back(result->observations.size());
  }
}

ExposureObservations observe(const World& world, size_t num_points = 5000) {
  Random random(7);
  ExposureObservations result;
  add_points(world, num_points, &random, &result);
  return result;
}

/// The largest error of a gain about their common mean, natural logarithm.
double largest_gain_error(const ExposureModel& model) {
  double mean = 0.0;
  for (const double gain : kLogGains) mean += gain / static_cast<double>(kLogGains.size());
  double largest = 0.0;
  for (size_t i = 0; i < kLogGains.size(); ++i) {
    EXPECT_TRUE(model.images[i].determined) << i;
    largest = std::max(largest, std::abs(model.images[i].log_gain - (kLogGains[i] - mean)));
  }
  return largest;
}

double largest_vignetting_error(const ExposureModel& model) {
  double largest = 0.0;
  for (size_t camera = 0; camera < kVignetting.size(); ++camera) {
    EXPECT_TRUE(model.cameras[camera].determined) << camera;
    for (double radius = 0.0; radius <= 1.0; radius += 0.05) {
      largest = std::max(largest, std::abs(log_vignetting(model.cameras[camera].coefficients, radius) -
                                           log_vignetting(kVignetting[camera], radius)));
    }
  }
  return largest;
}

TEST(Exposure, GainsAndVignettingAreRecoveredToOnePercent) {
  const ExposureModel model = estimate_exposure(observe({}), kCameras, 2, {});
  EXPECT_LT(largest_gain_error(model), 0.01);
  EXPECT_LT(largest_vignetting_error(model), 0.01);
  EXPECT_NEAR(model.residual, 0.02, 0.001);
  double sum = 0.0;
  for (const ImageExposure& image : model.images) sum += image.log_gain;
  EXPECT_NEAR(sum, 0.0, 1e-9);
}

TEST(Exposure, AFifthOfOutliersDoesNotMatter) {
  World world;
  world.outliers = 0.2;
  const ExposureModel model = estimate_exposure(observe(world), kCameras, 2, {});
  EXPECT_LT(largest_gain_error(model), 0.01);
  EXPECT_LT(largest_vignetting_error(model), 0.015);
}

TEST(Exposure, VignettingThatNothingTellsFromTheBrightnessOfPointsIsLeftOut) {
  World world;
  world.same_radius = true;
  world.images = {0, 1, 2};
  const ExposureModel model = estimate_exposure(observe(world), {0, 0, 0}, 1, {});
  EXPECT_FALSE(model.cameras[0].determined);
  EXPECT_EQ(model.cameras[0].coefficients, VignettingCoefficients{});
  EXPECT_NEAR(model.images[1].log_gain - model.images[0].log_gain, std::log(1.3 / 0.7), 0.01);
}

TEST(Exposure, ImagesThatShareNoPointHaveAGaugeOfTheirOwn) {
  Random random(3);
  ExposureObservations observations;
  World first, second;
  first.images = {0, 1, 2};
  second.images = {3, 4};
  add_points(first, 2000, &random, &observations);
  add_points(second, 2000, &random, &observations);
  const ExposureModel model = estimate_exposure(observations, kCameras, 2, {});
  EXPECT_NEAR(model.images[0].log_gain + model.images[1].log_gain + model.images[2].log_gain, 0.0, 1e-9);
  EXPECT_NEAR(model.images[3].log_gain + model.images[4].log_gain, 0.0, 1e-9);
  EXPECT_NEAR(model.images[4].log_gain - model.images[3].log_gain, 0.65, 0.01);
  EXPECT_FALSE(model.images[5].determined);
  EXPECT_EQ(model.images[5].log_gain, 0.0);
}

TEST(Exposure, TooFewObservationsDetermineNothing) {
  const ExposureModel model = estimate_exposure(observe({}, 6), kCameras, 2, {});
  for (const ImageExposure& image : model.images) EXPECT_FALSE(image.determined);
  for (const CameraVignetting& camera : model.cameras) EXPECT_FALSE(camera.determined);
  EXPECT_TRUE(estimate_exposure({}, kCameras, 2, {}).images.size() == kCameras.size());
}

TEST(Exposure, WhatIsNotWantedStaysZero) {
  ExposureOptions options;
  options.gains = false;
  EXPECT_FALSE(estimate_exposure(observe({}), kCameras, 2, options).images[0].determined);
  options = {};
  options.vignetting = false;
  EXPECT_FALSE(estimate_exposure(observe({}), kCameras, 2, options).cameras[0].determined);
}

TEST(Srgb, LevelsAndLightAreInverse) {
  EXPECT_EQ(light_of_level(0), 0.0f);
  EXPECT_EQ(light_of_level(255), 1.0f);
  EXPECT_NEAR(light_of_level(188), 0.503, 0.001);  // middle of the light is level 187.5
  for (int level = 0; level < 256; ++level) {
    EXPECT_NEAR(level_of_light(light_of_level(static_cast<uint8_t>(level))), level, 0.15) << level;
  }
  EXPECT_EQ(level_of_light(1.7f), 255.0f);
}

TEST(ExposureCorrection, DividesGainAndVignettingOutOfLight) {
  ExposureModel model;
  model.images = {{std::log(2.0), true}, {0.0, false}};
  model.cameras = {{{std::log(0.5), 0.0, 0.0}, true}, {}};
  const ExposureCorrection correction(model, {0, 1});
  const auto level = static_cast<uint8_t>(std::lround(level_of_light(0.4f)));
  const WeightedColor center = correction.corrected({{level, level, level}, 9, 0, 0});
  EXPECT_NEAR(center.color[0], level_of_light(0.2f), 0.5);
  EXPECT_EQ(center.weight, 9.0f);
  // At the corner half the light is missing, which makes up for the gain.
  EXPECT_NEAR(correction.corrected({{level, level, level}, 9, 0, 255}).color[1], level, 0.5);
  EXPECT_EQ(correction.corrected({{level, 7, 0}, 9, 1, 255}).color, (std::array<float, 3>{float(level), 7.0f, 0.0f}));
}

TEST(Vignetting, IsAppliedAsItIsTakenOut) {
  ColorImage picture(5, 1, Rgb{200, 100, 50});
  apply_vignetting({std::log(0.5), 0.0, 0.0}, &picture);
  EXPECT_EQ(picture.at(2, 0), (Rgb{200, 100, 50}));
  EXPECT_NEAR(picture.at(0, 0)[0], level_of_light(0.5f * light_of_level(200)), 0.6);
  ExposureModel model;
  model.images = {{}};
  model.cameras = {{{std::log(0.5), 0.0, 0.0}, true}};
  EXPECT_NEAR(ExposureCorrection(model, {0}).corrected({picture.at(4, 0), 9, 0, 255}).color[0], 200, 1.5);
}

TEST(ExposureObservations, LeaveOutClippedAndDarkSamplesAndPointsSeenOnce) {
  ColorSamples samples(4, 4);
  samples.add(0, {{100, 100, 100}, 200, 0, 0});
  samples.add(1, {{100, 100, 100}, 200, 0, 0});
  samples.add(1, {{255, 100, 100}, 200, 1, 0});
  samples.add(2, {{100, 100, 100}, 200, 0, 51});
  samples.add(2, {{3, 3, 3}, 200, 1, 0});
  samples.add(2, {{120, 120, 120}, 200, 2, 102});
  const ExposureObservations observations = collect_exposure_observations(samples, 3);
  ASSERT_EQ(observations.num_points(), 1u);
  ASSERT_EQ(observations.observations.size(), 2u);
  EXPECT_EQ(observations.observations[1].image, 2u);
  EXPECT_NEAR(observations.observations[1].radius, 0.4, 1e-6);
  EXPECT_NEAR(observations.observations[0].log_light, std::log(light_of_level(100)), 1e-6);
}

/// Far more points than are taken: two in three are seen twice, each as bright as its number says.
ColorSamples many_samples(size_t num_points) {
  ColorSamples samples(num_points, 2);
  for (size_t i = 0; i < num_points; ++i) {
    const auto level = static_cast<uint8_t>(50 + i % 190);
    samples.add(i, {{level, level, level}, 200, 0, 0});
    if (i % 3 != 1) samples.add(i, {{level, level, level}, 200, 1, 0});
  }
  return samples;
}

TEST(ExposureObservations, AreEvenlyTakenAndTheSameInParts) {
  constexpr size_t kNumPoints = 100001, kBorder = 31234;
  const ColorSamples samples = many_samples(kNumPoints);
  const ExposureObservations whole = collect_exposure_observations(samples, 2);
  ASSERT_EQ(whole.num_points(), 20000u);
  const size_t first = count_exposure_candidates(samples, 0, kBorder);
  const ExposureChoice choice(first + count_exposure_candidates(samples, kBorder, kNumPoints), 2);
  ExposureObservations parts;
  add_exposure_observations(samples, 0, kBorder, 0, choice, &parts);
  EXPECT_NEAR(static_cast<double>(parts.num_points()), 20000.0 * kBorder / kNumPoints, 2.0);
  add_exposure_observations(samples, kBorder, kNumPoints, first, choice, &parts);
  EXPECT_EQ(parts.point_begin, whole.point_begin);
  ASSERT_EQ(parts.observations.size(), whole.observations.size());
  for (size_t i = 0; i < whole.observations.size(); ++i) {
    ASSERT_EQ(parts.observations[i].log_light, whole.observations[i].log_light) << i;
  }
}

}  // namespace
}  // namespace cpplus
