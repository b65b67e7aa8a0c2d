#include "cpplus/simulate/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"
#include "cpplus/simulate/hash.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr float kContrastForMoreSamples = 0.06f;  // relative spread of a pixel's first samples
constexpr int kBlurSide = 4;                      // squared = samples a pixel of a blurred image
constexpr int kMeteringGrid = 48;                 // squared = rays that set the exposure
constexpr float kMiddleGrey = 0.20f;
constexpr float kWhite = 1.25f;  // exposed radiance at which the sensor saturates

float to_srgb(float linear) {
  const float x = std::clamp(linear, 0.0f, 1.0f);
  return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

/// Soft shoulder: highlights approach white instead of running into it.
float shoulder(float linear) {
  constexpr float kKnee = 0.6f;
  return linear < kKnee ? linear : kKnee + (1.0f - kKnee) * (1.0f - std::exp((kKnee - linear) / (1.0f - kKnee)));
}

}  // namespace

void RenderOptions::validate() const {
  check_option(samples_per_pixel >= 1 && samples_per_pixel <= 64, "samples_per_pixel", "[1, 64]", samples_per_pixel);
  check_option(noise_grey >= 0.0 && noise_grey <= 50.0, "noise_grey", "[0, 50]", noise_grey);
  check_option(exposure_sigma >= 0.0 && exposure_sigma <= 1.0, "exposure_sigma", "[0, 1]", exposure_sigma);
  check_option(readout_s >= 0.0 && readout_s <= 0.2, "readout_s", "[0, 0.2]", readout_s);
}

Renderer::Renderer(const Tracer& tracer, const SoftLight& light, const Camera& camera, const Path& path,
                   const Rigid3& lidar_from_camera, const RenderOptions& options)
    : tracer_(tracer),
      light_(light),
      camera_(camera),
      path_(path),
      lidar_from_camera_(lidar_from_camera),
      options_(options),
      corner_bearings_(camera.width() + 1, camera.height() + 1, Vector3f::Zero()) {
  parallel_for_each(static_cast<size_t>(corner_bearings_.height), [&](size_t row) {
    for (int x = 0; x < corner_bearings_.width; ++x) {
      const auto y = static_cast<int>(row);
      const auto ray = camera_.unproject(Vector2d(x - 0.5, y - 0.5));
      corner_bearings_.at(x, y) =
          ray ? Vector3f(ray->cast<float>()) : Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
    }
  });
}

Rigid3 Renderer::camera_from_map(double time_s) const {
  return inverse(path_.map_from_lidar(time_s) * lidar_from_camera_);
}

double Renderer::row_time(const Shot& shot, double row) const {
  return shot.stamp_s + options_.readout_s * (row / std::max(1, camera_.height() - 1) - 0.5);
}

std::optional<Vector2d> Renderer::project(const Shot& shot, const Eigen::Vector3d& x_in_map) const {
  constexpr int kIterations = 4;  // a row shift of a pixel changes the pose by far less than a pixel
  std::optional<Vector2d> pixel = camera_.project(camera_from_map(shot.stamp_s) * x_in_map);
  for (int i = 0; pixel && options_.readout_s > 0.0 && i < kIterations; ++i) {
    pixel = camera_.project(camera_from_map(row_time(shot, pixel->y())) * x_in_map);
  }
  return pixel;
}

Renderer::RowPose Renderer::pose_at(const Shot& shot, double row, double shutter) const {
  Rigid3 map_from_camera = path_.map_from_lidar(row_time(shot, row)) * lidar_from_camera_;
  if (shot.blur_px > 0.0) {
    // A turn about the axis across the blur moves the image centre along it.
    const double angle = shutter * shot.blur_px / camera_.pixels_per_radian();
    const Eigen::Vector3d axis(std::sin(shot.blur_direction_rad), -std::cos(shot.blur_direction_rad), 0.0);
    map_from_camera.rotation = map_from_camera.rotation * Eigen::Quaterniond(so3_exp(angle * axis));
  }
  return {map_from_camera.rotation.toRotationMatrix().cast<float>(), map_from_camera.translation.cast<float>()};
}

bool Renderer::bearing(double x, double y, Vector3f* bearing_in_camera) const {
  const int column = std::clamp(static_cast<int>(std::floor(x + 0.5)), 0, camera_.width() - 1);
  const int row = std::clamp(static_cast<int>(std::floor(y + 0.5)), 0, camera_.height() - 1);
  const auto s = static_cast<float>(x + 0.5 - column);
  const auto t = static_cast<float>(y + 0.5 - row);
  // Within one pixel a bearing is linear to far below a thousandth of a pixel.
  const Vector3f mixed =
      (1 - s) * (1 - t) * corner_bearings_.at(column, row) + s * (1 - t) * corner_bearings_.at(column + 1, row) +
      (1 - s) * t * corner_bearings_.at(column, row + 1) + s * t * corner_bearings_.at(column + 1, row + 1);
  if (mixed.allFinite() && mixed.squaredNorm() > 0.5f) {
    *bearing_in_camera = mixed.normalized();
    return true;
  }
  const auto exact = camera_.unproject(Vector2d(x, y));
  if (!exact) return false;
  *bearing_in_camera = exact->cast<float>();
  return true;
}

Vector3f Renderer::radiance(const RowPose& pose, const BodyPoses& bodies, const Vector3f& bearing_in_camera) const {
  const Scene& scene = tracer_.scene();
  const Vector3f direction = pose.map_from_camera * bearing_in_camera;
  const auto hit = tracer_.trace(pose.origin, direction, bodies);
  if (!hit) return sky_radiance(scene.sky, direction);
  const Material& material = *hit->material;
  if (material.emission > 0.0f) return material.emission * material.color;
  const float cosine = std::max(0.05f, -hit->normal.dot(direction));
  const float footprint = hit->range / static_cast<float>(camera_.pixels_per_radian()) / std::sqrt(cosine);
  Vector3f incoming = light_.at(*hit);
  const float sun_cosine = hit->normal.dot(scene.sky.sun_direction);
  if (sun_cosine > 0.0f && scene.sky.sun_irradiance.maxCoeff() > 0.0f) {
    const Vector3f lifted = hit->point + 2e-3f * hit->normal;
    if (!tracer_.occluded(lifted, scene.sky.sun_direction, 1e4f, bodies)) {
      incoming += scene.sky.sun_irradiance * (sun_cosine / static_cast<float>(M_PI));
    }
  }
  return albedo(material, hit->uv, footprint).cwiseProduct(incoming);
}

Vector3f Renderer::sample_cells(const Shot& shot, const RowPose& row_pose, const BodyPoses& bodies, float gain, int x,
                                int y, int side, int round, float* contrast) const {
  const uint64_t pixel = static_cast<uint64_t>(y) * static_cast<uint64_t>(camera_.width()) + static_cast<uint64_t>(x);
  Random random(hash_seed(shot.seed, pixel, static_cast<uint64_t>(round)));
  const int count = side * side;
  Vector3f sum = Vector3f::Zero();
  float low = std::numeric_limits<float>::max();
  float high = 0.0f;
  RowPose pose = row_pose;
  for (int i = 0; i < count; ++i) {
    const double px = x - 0.5 + (i % side + random.uniform()) / side;
    const double py = y - 0.5 + (i / side + random.uniform()) / side;
    if (shot.blur_px > 0.0) {
      // Instants in strata too, scattered over the cells so that time and place are independent.
      pose = pose_at(shot, y, ((i * 7 + round) % count + random.uniform()) / count - 0.5);
    }
    Vector3f ray = Vector3f::Zero();
    Vector3f value = Vector3f::Zero();
    if (bearing(px, py, &ray)) value = radiance(pose, bodies, ray);
    // Saturation before averaging: a lamp does not grow by the pixels that it only touches.
    value = value.cwiseMin(kWhite / gain);
    sum += value;
    low = std::min(low, value.mean());
    high = std::max(high, value.mean());
  }
  *contrast = (high - low) / (0.5f * (high + low) + 1e-3f);
  return sum / static_cast<float>(count);
}

void Renderer::render_row(const Shot& shot, float gain, int y, Image<Vector3f>* linear) const {
  const int side = static_cast<int>(std::ceil(std::sqrt(std::max(1, options_.samples_per_pixel))));
  const RowPose pose = pose_at(shot, y, 0.0);
  const BodyPoses bodies = body_poses(tracer_.scene(), row_time(shot, y));
  for (int x = 0; x < camera_.width(); ++x) {
    float contrast = 0.0f;
    if (shot.blur_px > 0.0) {
      linear->at(x, y) = sample_cells(shot, pose, bodies, gain, x, y, std::max(side, kBlurSide), 0, &contrast);
      continue;
    }
    const Vector3f first = sample_cells(shot, pose, bodies, gain, x, y, side, 0, &contrast);
    if (contrast < kContrastForMoreSamples) {
      linear->at(x, y) = first;
      continue;
    }
    // The first samples only decide; averaging them in as well would favour whatever made them differ.
    linear->at(x, y) = sample_cells(shot, pose, bodies, gain, x, y, 2 * side, 1, &contrast);
  }
}

/// As a camera's automatic: the logarithmic mean becomes a middle grey, unless the brightest tenth would be lost.
float Renderer::metered_gain(const Shot& shot) const {
  std::vector<float> values;
  double sum_of_logs = 0.0;
  for (int i = 0; i < kMeteringGrid; ++i) {
    const double y = (i + 0.5) * camera_.height() / kMeteringGrid - 0.5;
    const RowPose pose = pose_at(shot, y, 0.0);
    const BodyPoses bodies = body_poses(tracer_.scene(), row_time(shot, y));
    for (int k = 0; k < kMeteringGrid; ++k) {
      Vector3f ray = Vector3f::Zero();
      if (!bearing((k + 0.5) * camera_.width() / kMeteringGrid - 0.5, y, &ray)) continue;
      values.push_back(std::max(1e-4f, radiance(pose, bodies, ray).mean()));
      sum_of_logs += std::log(values.back());
    }
  }
  if (values.empty()) return 1.0f;
  const auto bright = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 9 / 10);
  std::nth_element(values.begin(), bright, values.end());
  const auto mean = static_cast<float>(std::exp(sum_of_logs / static_cast<double>(values.size())));
  return std::min(kMiddleGrey / mean, 0.85f / *bright);
}

ColorImage Renderer::render(const Shot& shot) const {
  Random shot_random(hash_seed(shot.seed, 0xE1));
  const float gain = metered_gain(shot) * static_cast<float>(std::exp(options_.exposure_sigma * shot_random.normal()));
  Image<Vector3f> linear(camera_.width(), camera_.height(), Vector3f::Zero());
  parallel_for_each(static_cast<size_t>(camera_.height()),
                    [&](size_t row) { render_row(shot, gain, static_cast<int>(row), &linear); });
  ColorImage image(camera_.width(), camera_.height());
  parallel_for_chunks(linear.pixels.size(), 65536, [&](size_t begin, size_t end) {
    Random random(hash_seed(shot.seed, 0xA5, begin));
    for (size_t i = begin; i < end; ++i) {
      for (int k = 0; k < 3; ++k) {
        const float value = to_srgb(shoulder(gain * linear.pixels[i][k]));
        // Shot noise, flattened by the gamma curve, plus what the electronics add.
        const double noise =
            options_.noise_grey * random.normal() * (0.6 + 0.8 * std::sqrt(value * (1.0f - 0.5f * value)));
        image.pixels[i][static_cast<size_t>(k)] =
            static_cast<uint8_t>(std::clamp(255.0 * value + noise + 0.5, 0.0, 255.0));
      }
    }
  });
  return image;
}

RangeImage Renderer::range(const Shot& shot, int step, double offset) const {
  RangeImage image((camera_.width() + step - 1) / step, (camera_.height() + step - 1) / step);
  parallel_for_each(static_cast<size_t>(image.height), [&](size_t row) {
    const double y = step * static_cast<double>(row) + offset;
    const RowPose pose = pose_at(shot, y, 0.0);
    for (int column = 0; column < image.width; ++column) {
      const auto ray = camera_.unproject(Vector2d(step * column + offset, y));
      if (!ray) continue;
      const auto hit = tracer_.trace_static(pose.origin, pose.map_from_camera * ray->cast<float>());
      if (hit) image.at(column, static_cast<int>(row)) = hit->range;
    }
  });
  return image;
}

double Renderer::moving_share(const Shot& shot, int step) const {
  size_t moving = 0;
  size_t total = 0;
  for (int y = step / 2; y < camera_.height(); y += step) {
    const RowPose pose = pose_at(shot, y, 0.0);
    const BodyPoses bodies = body_poses(tracer_.scene(), row_time(shot, y));
    for (int x = step / 2; x < camera_.width(); x += step) {
      Vector3f ray = Vector3f::Zero();
      ++total;
      if (!bearing(x, y, &ray)) continue;
      const auto hit = tracer_.trace(pose.origin, pose.map_from_camera * ray, bodies);
      if (hit && hit->body >= 0) ++moving;
    }
  }
  return total == 0 ? 0.0 : static_cast<double>(moving) / static_cast<double>(total);
}

}  // namespace cpplus
