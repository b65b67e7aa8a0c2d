#include "cpplus/pipeline/report_pictures.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/geometry/scaled_camera.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/image_io.h"
#include "cpplus/pipeline/image_folder.h"
#include "cpplus/pipeline/sample_dashes.h"
#include "cpplus/report/report_page.h"
#include "cpplus/report/shrink_image.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

constexpr int kThumbnailSizePx = 200;
constexpr int kJpegQuality = 82;

// What the pictures were made of: the time of report.json tells one result from the next.
std::string fingerprint(const RefineResult& result, int picture_size_px) {
  const auto changed = fs::last_write_time(result.folder + "/report.json").time_since_epoch().count();
  return fmt::format("{}\n{}\n{}\n{}\n{}\n", changed, result.inputs.map, result.inputs.images, result.inputs.poses,
                     picture_size_px);
}

std::string read_if_there(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<std::string> files_of(const std::string& folder, size_t image) {
  const PicturePaths paths = picture_paths(image);
  return {folder + "/" + paths.thumbnail, folder + "/" + paths.before, folder + "/" + paths.after};
}

bool all_exist(const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    if (!fs::exists(file)) return false;
  }
  return true;
}

void write_pictures(const RefineResult& result, const MapFeatures& features, const PosedImage& coarse,
                    const Rigid3& refined, const std::vector<std::string>& files, int picture_size_px) {
  const Camera& camera = result.coarse.cameras.at(coarse.camera_id);
  const std::string path = image_path(result.inputs.images, coarse.name);
  const ColorImage photo = read_color_image(path);
  if (photo.width != camera.width() || photo.height != camera.height()) {
    throw Error(fmt::format("{}: the image is {}x{}, its camera {}x{}", path, photo.width, photo.height, camera.width(),
                            camera.height()));
  }
  const EdgesInView view = find_edges_in_view(features, camera, refined, result.stages);
  const std::vector<OverlaySegment> segments =
      sample_dashes(view.samples, camera, refined, result.stages.samples.spacing_px);
  const double factor = shrink_factor(photo.width, photo.height, picture_size_px);
  const Camera small_camera = scaled_camera(camera, factor);
  ColorImage before = overlay_background(shrink_image(photo, factor));
  ColorImage after = before;
  draw_segments(segments, small_camera, coarse.camera_from_map, kBeforeColor, &before);
  draw_segments(segments, small_camera, refined, kAfterColor, &after);
  write_jpeg(files[0], shrink_image(photo, shrink_factor(photo.width, photo.height, kThumbnailSizePx)), kJpegQuality);
  write_jpeg(files[1], before, kJpegQuality);
  write_jpeg(files[2], after, kJpegQuality);
}

}  // namespace

PicturePlan plan_pictures(const RefineResult& result, const std::string& folder, int picture_size_px) {
  const std::vector<std::string>& names = result.image_names;
  const std::string marker = folder + "/pictures/made_of.txt";
  const std::string made_of = fingerprint(result, picture_size_px);
  if (read_if_there(marker) != made_of) {
    std::error_code ignored;  // what stands in the way is found when the files are written
    for (size_t i = 0; i < names.size(); ++i) {
      for (const std::string& file : files_of(folder, i)) fs::remove(file, ignored);
    }
    fs::remove(folder + "/floor_plan.png", ignored);
    write_text_file(marker, made_of);
  }
  PicturePlan plan;
  const std::vector<size_t> places = places_in_model(names, result.coarse);
  for (size_t i = 0; i < names.size(); ++i) {
    if (places[i] == result.coarse.images.size()) continue;
    if (!fs::is_regular_file(image_path(result.inputs.images, names[i]))) continue;
    (all_exist(files_of(folder, i)) ? plan.kept : plan.missing).push_back(i);
  }
  return plan;
}

std::vector<size_t> draw_pictures(const RefineResult& result, GroupedFeatures* features,
                                  const std::vector<size_t>& images, const std::string& folder, int picture_size_px) {
  const std::vector<std::string>& names = result.image_names;
  const std::vector<size_t> coarse_places = places_in_model(names, result.coarse);
  const std::vector<size_t> refined_places = places_in_model(names, result.refined);
  std::vector<std::string> problems(images.size());
  Progress progress("draw pictures", images.size());
  const auto draw = [&](const MapFeatures& near, size_t k) {
    const size_t i = images[k];
    const PosedImage& coarse = result.coarse.images[coarse_places[i]];
    const bool in_refined = refined_places[i] < result.refined.images.size();
    const Rigid3& refined =
        in_refined ? result.refined.images[refined_places[i]].camera_from_map : coarse.camera_from_map;
    try {
      write_pictures(result, near, coarse, refined, files_of(folder, i), picture_size_px);
    } catch (const Error& error) {
      problems[k] = error.what();
    }
    progress.advance();
  };
  std::vector<size_t> places;
  std::map<size_t, size_t> number_of;  // in `images`, by place in the coarse model
  for (size_t k = 0; k < images.size(); ++k) {
    places.push_back(coarse_places[images[k]]);
    number_of[places.back()] = k;
  }
  features->for_each_group(places, [&](const MapFeatures& near, const std::vector<size_t>& some) {
    parallel_for_each(some.size(), [&](size_t s) { draw(near, number_of.at(some[s])); });
  });
  std::vector<size_t> drawn;
  for (size_t k = 0; k < images.size(); ++k) {
    if (problems[k].empty()) {
      drawn.push_back(images[k]);
    } else {
      log_warning("no picture: " + problems[k]);
    }
  }
  return drawn;
}

}  // namespace cpplus
