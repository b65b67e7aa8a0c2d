#include "cpplus/pipeline/export_surfaces.h"

#include <algorithm>
#include <cmath>

#include "cpplus/pipeline/map_discs.h"

namespace cpplus {

Image<float> depth_of(const SurfaceView& view, const Image<Eigen::Vector3f>& bearings, const std::string& kind) {
  Image<float> depth = view.range;
  if (kind == "range") return depth;
  for (size_t i = 0; i < depth.pixels.size(); ++i) {
    depth.pixels[i] = std::max(0.0f, depth.pixels[i] * bearings.pixels[i].z());
  }
  return depth;
}

DeepImage depth_in_mm(const Image<float>& depth_m) {
  constexpr float kLargest = 65535.0f;
  DeepImage depth_mm(depth_m.width, depth_m.height);
  for (size_t i = 0; i < depth_m.pixels.size(); ++i) {
    const float mm = std::round(1000.0f * depth_m.pixels[i]);
    depth_mm.pixels[i] = mm > 0.0f && mm <= kLargest ? static_cast<uint16_t>(mm) : uint16_t{0};
  }
  return depth_mm;
}

DeepColorImage normals_in_16_bits(const Image<Eigen::Vector3f>& normals) {
  DeepColorImage colors(normals.width, normals.height);
  for (size_t i = 0; i < normals.pixels.size(); ++i) {
    const Eigen::Vector3f& normal = normals.pixels[i];
    if (normal.isZero()) continue;
    for (size_t c = 0; c < 3; ++c) {
      const float value = 0.5f * (std::clamp(normal[static_cast<Eigen::Index>(c)], -1.0f, 1.0f) + 1.0f);
      colors.pixels[i][c] = static_cast<uint16_t>(std::lround(65535.0f * value));
    }
  }
  return colors;
}

SurfaceRenderer::SurfaceRenderer(const VoxelMap& map, const SurfaceViewOptions& options)
    : map_(map), options_(options), discs_(make_map_discs(map)) {}

const Image<Eigen::Vector3f>& SurfaceRenderer::bearings(uint32_t camera_id, const Camera& camera) {
  const auto found = bearings_.find(camera_id);
  return found != bearings_.end() ? found->second : bearings_.emplace(camera_id, pixel_bearings(camera)).first->second;
}

SurfaceView SurfaceRenderer::render(uint32_t camera_id, const Camera& camera, const Rigid3& camera_from_map) {
  return render_surface(map_, discs_, camera, bearings(camera_id, camera), camera_from_map, options_);
}

}  // namespace cpplus
