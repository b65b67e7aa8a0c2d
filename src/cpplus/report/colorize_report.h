#pragma once

#include <string>
#include <vector>

#include "cpplus/colorize/colorize.h"
#include "cpplus/evaluate/image_difference.h"

namespace cpplus {

/// How well the coloured cloud foretells an image that gave no colour.
struct HeldOutImage {
  std::string name;
  ImageDifference difference;
  bool blurred = false;  // shows what moved, not what the cloud looks like: no judge of it
};

/// All covered pixels of the held-out images that are not blurred together, each counting the same.
ImageDifference total_difference(const std::vector<HeldOutImage>& images);

/// One JSON object: `images` (name, id, gain, whether it is determined), `cameras` (id, vignetting coefficients,
/// brightness at the corner), `exposure_residual`, and `held_out` (PSNR in dB as it is and with matched exposure, share
/// of pixels covered; in total and by image, blurred ones included there), null where no image was held out. The
/// result's cloud is not read.
std::string colorize_report_json(const ColorizeResult& result, const std::vector<HeldOutImage>& held_out);

}  // namespace cpplus
