#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cpplus/colorize/color_samples.h"
#include "cpplus/colorize/exposure.h"
#include "cpplus/colorize/robust_color.h"
#include "cpplus/core/image.h"

namespace cpplus {

/// Log light of the kept samples of points that several images see, for estimate_exposure: at most 20000 points or 400
/// an image, evenly over the map. Samples with a channel near white (clipped) or with hardly any light are left out.
ExposureObservations collect_exposure_observations(const ColorSamples& samples, size_t num_images);

/// Which points that takes where the samples of a map come in parts, so that it is the same for any parts.
class ExposureChoice {
 public:
  /// num_candidates: of the whole map, see count_exposure_candidates.
  ExposureChoice(size_t num_candidates, size_t num_images);

  /// Whether the candidate with that rank (in map order, among those of the whole map) is taken.
  bool takes(size_t rank) const;

 private:
  size_t num_candidates_;
  size_t budget_;
};

/// How many of the points [begin, end) several kept samples show.
size_t count_exposure_candidates(const ColorSamples& samples, size_t begin, size_t end);

/// Appends what the points [begin, end) contribute; the first candidate among them has first_rank.
void add_exposure_observations(const ColorSamples& samples, size_t begin, size_t end, size_t first_rank,
                               const ExposureChoice& choice, ExposureObservations* observations);

/// Divides gain and vignetting out of samples, in linear light.
class ExposureCorrection {
 public:
  ExposureCorrection() = default;  // of no images
  ExposureCorrection(const ExposureModel& model, const std::vector<uint32_t>& camera_of_image);

  /// The sample as an image of gain 1 without vignetting shows it; brighter than white stays white.
  WeightedColor corrected(const ColorSample& sample) const;

 private:
  struct PerImage {
    float factor = 1.0f;
    uint32_t camera = 0;
  };
  std::vector<PerImage> images_;
  std::vector<std::array<float, 256>> cameras_;  // factor by radius
  std::vector<bool> is_changed_;                 // by image: anything to divide out
};

/// Darkens a picture towards its corners as a camera with that vignetting does: what ExposureCorrection takes out.
void apply_vignetting(const VignettingCoefficients& coefficients, ColorImage* picture);

}  // namespace cpplus
