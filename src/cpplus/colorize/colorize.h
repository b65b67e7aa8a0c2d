#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/colorize/color_samples.h"
#include "cpplus/colorize/exposure.h"
#include "cpplus/colorize/exposure_correction.h"
#include "cpplus/colorize/gray_scale.h"
#include "cpplus/colorize/view_sampler.h"

namespace cpplus {

struct ColorizeOptions {
  ViewSamplingOptions sampling;
  ExposureOptions exposure;
  /// The best samples kept of each point; memory grows with it, by 8 bytes a point. [1, 64]
  int max_samples = 8;
  /// A sample that differs by more than this from what most samples of its point say is taken for an outlier.
  /// Grey levels, [0, 255]
  double max_deviation = 30.0;
  /// Voxels that surface normals are fitted in; metres. (0, inf)
  double normal_voxel_m = 0.25;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor.group("sampling", sampling);
    visitor.group("exposure", exposure);
    visitor("max_samples", max_samples, "The best colour samples kept of each point. [1, 64]");
    visitor("max_deviation", max_deviation,
            "A sample farther than this from what most say of its point is an outlier, grey levels. [0, 255]");
    visitor("normal_voxel_m", normal_voxel_m, "Voxels that surface normals are fitted in, metres.");
  }
};

/// Yields the views one after the other, in the order of their indices, then nothing. One is looked at while the next one
/// is asked for, maybe by another thread, and no more are held.
using NextColorView = std::function<std::optional<ColorView>()>;

/// What was found out about an image that gave colours.
struct ColorizedImage {
  std::string name;
  uint32_t image_id = 0;
  uint32_t camera_id = 0;
  ImageExposure exposure;
};

struct ColorizeResult {
  /// The input's points in the input's order and with its other attributes; `colors`, `num_views`, `best_images` and
  /// `color_spreads` are new. A point that no image shows has 0 in the last three and the grey of its intensity
  /// (GrayScale).
  PointCloud cloud;                                 // of colorize() alone
  std::vector<ColorizedImage> images;               // in the order of the views
  std::map<uint32_t, CameraVignetting> vignetting;  // by camera id
  double exposure_residual = 0.0;                   // see ExposureModel; 0 where nothing was estimated
  size_t num_colored = 0;                           // points with num_views > 0
};

/// What was found out about a point of a map.
struct ColoredPoint {
  Rgb color{};              // what the images agree on; not set where num_views is 0
  uint8_t spread = 0;       // see PointCloud::color_spreads
  uint16_t num_views = 0;   // see PointCloud::num_views
  uint32_t best_image = 0;  // id in the model
};

/// The colours of a map in three steps, so that it can be taken in parts. First: what the images show of the points of
/// a map, or of a part of one (cloud/map_part.h), in its order. Samples have the index of their view. Memory is 3 + 8 *
/// max_samples bytes a point.
ColorSamples collect_color_samples(const VoxelMap& map, const NextColorView& next_view, const ColorizeOptions& options);

/// Then: the exposure of result->images, which the observations' and the samples' indices mean; it is put into the
/// result.
ExposureCorrection equalize_exposure(const ExposureObservations& observations, const ExposureOptions& options,
                                     ColorizeResult* result);

/// Last: the colours of all points that have samples.
std::vector<ColoredPoint> color_points(const ColorSamples& samples, const ExposureCorrection& correction,
                                       const std::vector<ColorizedImage>& images, double max_deviation);

/// The index of a view as samples keep it. Throws Error naming the image for the 65537th.
uint16_t color_view_index(size_t index, const std::string& name);

/// Gives every point the colour on which the images that really see it agree (robust_color), after their exposure has
/// been made equal (estimate_exposure): all three steps. `map` must have been built from `cloud`; a point that it
/// dropped (not finite) is seen by no image. Views are numbered in their order. Throws Error for more than 65536
/// images. Time is linear in images times points in their frusta; memory is the cloud plus 15 + 8 * max_samples bytes a
/// point. The result does not depend on the number of threads.
ColorizeResult colorize(PointCloud cloud, const VoxelMap& map, const NextColorView& next_view,
                        const ColorizeOptions& options);

}  // namespace cpplus
