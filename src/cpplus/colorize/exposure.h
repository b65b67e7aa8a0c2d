#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cpplus {

struct ExposureOptions {
  /// Estimate one gain an image and divide it out.
  bool gains = true;
  /// Estimate the fall of brightness towards the corners of each camera and divide it out.
  bool vignetting = true;

  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("gains", gains, "Make images of different exposure equally bright.");
    visitor("vignetting", vignetting, "Make up for corners darker than the centre, by camera.");
  }
};

/// How bright one point is in one image.
struct ExposureObservation {
  uint32_t image = 0;
  float log_light = 0.0f;  // natural logarithm of the linear light
  float radius = 0.0f;     // distance from the image centre over half the diagonal, [0, 1]
  float weight = 1.0f;     // inverse variance of log_light, up to a common factor
};

/// Observations of points that several images see, those of a point together.
struct ExposureObservations {
  std::vector<size_t> point_begin = {0};  // of points and one more
  std::vector<ExposureObservation> observations;

  size_t num_points() const { return point_begin.size() - 1; }
};

/// Coefficients of r^2, r^4 and r^6.
using VignettingCoefficients = std::array<double, 3>;

struct ImageExposure {
  double log_gain = 0.0;    // natural logarithm; 0 where not determined
  bool determined = false;  // enough points are seen by other images too
};

struct CameraVignetting {
  VignettingCoefficients coefficients{};  // all 0 where not determined
  bool determined = false;
};

struct ExposureModel {
  std::vector<ImageExposure> images;
  std::vector<CameraVignetting> cameras;
  double residual = 0.0;  // robust standard deviation of log_light
};

/// Gains and vignetting together, by robust linear least squares (iteratively reweighted, Geman-McClure):
///
///     log_light = b_point + a_image + v_1 r^2 + v_2 r^4 + v_3 r^6      (v of the image's camera)
///
/// The brightness b of each point is eliminated, which leaves a sparse system in the images and cameras. Gauge: within
/// each set of images that share points the mean of a is 0. An image with fewer than 20 observations, and vignetting
/// whose fall at the corner is known no better than 3 %, are not determined and stay 0.
/// `camera_of_image`: index of a camera below num_cameras, by image. Linear in the observations.
ExposureModel estimate_exposure(const ExposureObservations& observations, const std::vector<uint32_t>& camera_of_image,
                                size_t num_cameras, const ExposureOptions& options);

/// Natural logarithm of the brightness at a radius over that at the centre.
double log_vignetting(const VignettingCoefficients& coefficients, double radius);

}  // namespace cpplus
