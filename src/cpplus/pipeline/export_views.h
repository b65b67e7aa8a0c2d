#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/core/image.h"
#include "cpplus/geometry/pinhole_views.h"
#include "cpplus/geometry/sparse_model.h"
#include "cpplus/render/resample_image.h"

namespace cpplus {

/// An image that an export writes or describes: a posed image of the model, or a pinhole view of one.
struct ExportView {
  size_t source = 0;  // index into the model's images
  PosedImage image;   // its own id, name and pose; the id of its camera in ExportViews
  Eigen::Quaterniond view_from_camera = Eigen::Quaterniond::Identity();
  bool is_resampled = false;  // its pixels are not those of the source
};

struct ExportViews {
  std::map<uint32_t, Camera> cameras;
  std::vector<ExportView> views;  // those of one source follow each other
};

/// The images (indices into model.images) as they are.
ExportViews recorded_views(const SparseModel& model, const std::vector<size_t>& images);

/// Their pinhole views. Ids of cameras stay; ids of images stay where each has one view. A resampled view keeps the
/// name of its image, with the suffix of a face, and .png instead of an extension other than .jpg .jpeg .png. Throws
/// Error where two views would have one name.
ExportViews undistorted_views(const SparseModel& model, const std::vector<size_t>& images,
                              const PinholeViewOptions& options);

/// Reads the images of views, in their order: each file once, one held at a time.
class ExportImages {
 public:
  /// References must outlive it.
  ExportImages(std::string directory, const SparseModel& model, const ExportViews& views);

  /// The pixels of a view; nothing, after a warning, where the source is unreadable or not of its camera's size.
  std::optional<ColorImage> read(const ExportView& view);
  /// Writes the view's pixels to the path: a copy of the file where nothing was resampled, else JPEG or PNG.
  void write(const ExportView& view, const ColorImage& pixels, const std::string& path, int jpeg_quality) const;

 private:
  std::string source_path(const ExportView& view) const;
  void load(const ExportView& view);
  const ResampleTable& table_of(const ExportView& view);

  std::string directory_;
  const SparseModel& model_;
  const ExportViews& views_;
  std::optional<size_t> loaded_;  // the source that `source_image_` is of
  std::optional<ColorImage> source_image_;
  std::map<std::pair<uint32_t, std::vector<double>>, ResampleTable> tables_;  // by camera and rotation
};

}  // namespace cpplus
