#include "cpplus/render/resample_image.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

constexpr float kNowhere = -1e6f;

/// A view to the inner memory, which the function called does not change.
template <typename Pixel>
cv::Mat mat_of(const Image<Pixel>& image, int type) {
  return cv::Mat(image.height, image.width, type, const_cast<Pixel*>(image.pixels.data()));
}

/// The image with its last column before the first one and its first two after the last one.
cv::Mat with_seam(const cv::Mat& image) {
  cv::Mat wide;
  cv::hconcat(std::vector<cv::Mat>{image.col(image.cols - 1), image, image.colRange(0, 2)}, wide);
  return wide;
}

}  // namespace

ResampleTable make_resample_table(const Camera& camera, const Camera& view,
                                  const Eigen::Quaterniond& view_from_camera) {
  ResampleTable table{Image<float>(view.width(), view.height(), kNowhere),
                      Image<float>(view.width(), view.height(), kNowhere)};
  parallel_for_chunks(static_cast<size_t>(view.height()), 16, [&](size_t begin, size_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < view.width(); ++x) {
        const auto bearing_in_view = view.unproject(Eigen::Vector2d(x, y));
        if (!bearing_in_view) continue;
        const auto pixel = camera.project(view_from_camera.conjugate() * *bearing_in_view);
        if (!pixel || !camera.in_image(*pixel, -0.5)) continue;
        table.x.at(x, y) = static_cast<float>(pixel->x());
        table.y.at(x, y) = static_cast<float>(pixel->y());
      }
    }
  });
  return table;
}

ColorImage resample_image(const ColorImage& image, const ResampleTable& table, bool wraps) {
  const cv::Mat recorded = mat_of(image, CV_8UC3);
  const cv::Mat source = wraps && image.width > 2 ? with_seam(recorded) : recorded;
  const cv::Mat columns = source.cols == image.width ? mat_of(table.x, CV_32FC1) : mat_of(table.x, CV_32FC1) + 1.0;
  const cv::Mat rows = mat_of(table.y, CV_32FC1);
  ColorImage result(table.x.width, table.x.height);
  cv::Mat target = mat_of(result, CV_8UC3);
  cv::remap(source, target, columns, rows, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  for (size_t i = 0; i < result.pixels.size(); ++i) {  // outside, the border is repeated without end
    if (table.x.pixels[i] == kNowhere) result.pixels[i] = {0, 0, 0};
  }
  return result;
}

}  // namespace cpplus
