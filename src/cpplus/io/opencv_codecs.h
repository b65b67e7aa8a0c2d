#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cv {
class Mat;
}

namespace cpplus {

/// OpenCV's codecs. Their library draws in some 130 others, which cost every start of the program 45 MB and a tenth of
/// a second; so it is loaded by the first image that needs it. Throws Error where it cannot be loaded.

/// cv::imdecode.
cv::Mat opencv_decode(const std::vector<uint8_t>& bytes, int flags);

/// cv::imencode; `extension` with its dot. Empty where it fails.
std::vector<uint8_t> opencv_encode(const std::string& extension, const cv::Mat& bgr,
                                   const std::vector<int>& parameters);

}  // namespace cpplus
