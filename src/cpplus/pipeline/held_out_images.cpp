#include "cpplus/pipeline/held_out_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "cpplus/colorize/exposure_correction.h"
#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/parallel.h"
#include "cpplus/features/blur.h"
#include "cpplus/io/image_io.h"
#include "cpplus/pipeline/color_view_depth.h"
#include "cpplus/pipeline/image_folder.h"
#include "cpplus/report/render_cloud.h"

namespace cpplus {
namespace {

/// Nothing, with a warning, for an image that cannot be used.
std::optional<HeldOutImage> compare(const std::string& image_folder, const PosedImage& image, const Camera& camera,
                                    const SparseModel& poses, const ColoredCloud& cloud, const ColorizeResult& result,
                                    const HeldOutRendering& options) {
  const auto posed = std::find_if(poses.images.begin(), poses.images.end(),
                                  [&](const PosedImage& other) { return other.name == image.name; });
  if (posed == poses.images.end()) {
    log_warning(fmt::format("{}: held out, but has no pose to be rendered from", image.name));
    return std::nullopt;
  }
  try {
    const ColorImage photo = read_color_image(image_path(image_folder, image.name));
    const DepthBuffer surface =
        color_view_depth(cloud.points.map, camera, posed->camera_from_map, options.max_distance_m);
    CloudRendering rendering = render_colored_cloud(drawn_points(cloud, surface, posed->camera_from_map), surface,
                                                    posed->camera_from_map, options.point_size_m);
    const auto vignetting = result.vignetting.find(image.camera_id);
    if (vignetting != result.vignetting.end() && vignetting->second.determined) {
      apply_vignetting(vignetting->second.coefficients, &rendering.picture);
    }
    return HeldOutImage{image.name, compare_images(photo, rendering.picture, rendering.colored),
                        measure_blur(to_gray(photo), {}).blurred};
  } catch (const Error& error) {
    log_warning(fmt::format("held-out image {}: {}", image.name, error.what()));
    return std::nullopt;
  }
}

}  // namespace

HeldOutSplit split_images(const std::vector<size_t>& images, int every) {
  HeldOutSplit split;
  for (size_t k = 0; k < images.size(); ++k) {
    const bool held_out = every > 1 && (k + 1) % static_cast<size_t>(every) == 0;
    (held_out ? split.held_out : split.colored).push_back(images[k]);
  }
  return split;
}

std::vector<HeldOutImage> compare_held_out(const std::string& image_folder, const SparseModel& model,
                                           const std::vector<size_t>& held_out, const SparseModel& poses,
                                           const ColoredCloud& cloud, const ColorizeResult& result,
                                           const HeldOutRendering& rendering) {
  std::vector<std::optional<HeldOutImage>> compared(held_out.size());
  parallel_for_each(held_out.size(), [&](size_t k) {
    const PosedImage& image = model.images[held_out[k]];
    compared[k] = compare(image_folder, image, model.cameras.at(image.camera_id), poses, cloud, result, rendering);
  });
  std::vector<HeldOutImage> images;
  for (std::optional<HeldOutImage>& image : compared) {
    if (!image) continue;
    if (image->blurred) log_info(fmt::format("{}: held out, but blurred: not counted", image->name));
    images.push_back(std::move(*image));
  }
  return images;
}

}  // namespace cpplus
