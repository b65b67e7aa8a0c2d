#include "cpplus/evaluate/checkerboard_residual.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/evaluate/statistics.h"

namespace cpplus {

double checkerboard_residual_px(const std::vector<Checkerboard>& boards, const std::string& image_name,
                                const Camera& camera, const Rigid3& camera_from_map) {
  const double cap_px = std::hypot(camera.width(), camera.height());
  std::vector<double> distances_px;
  for (const Checkerboard& board : boards) {
    for (const Checkerboard::Sighting& sighting : board.sightings) {
      if (sighting.image_name != image_name) continue;
      if (sighting.corner_pixels.size() != board.corners_in_map.size()) {
        throw Error(fmt::format("checkerboard {} in image {}: {} corners in the image, {} on the board", board.name,
                                image_name, sighting.corner_pixels.size(), board.corners_in_map.size()));
      }
      for (size_t i = 0; i < sighting.corner_pixels.size(); ++i) {
        const auto pixel = camera.project(camera_from_map * board.corners_in_map[i]);
        distances_px.push_back(pixel ? std::min(cap_px, (*pixel - sighting.corner_pixels[i]).norm()) : cap_px);
      }
    }
  }
  return sample_statistics(std::move(distances_px)).mean;
}

}  // namespace cpplus
