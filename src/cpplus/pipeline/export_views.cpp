#include "cpplus/pipeline/export_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/io/image_io.h"
#include "cpplus/pipeline/image_folder.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

std::string lower_extension(const std::string& name) {
  std::string extension = fs::path(name).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_jpeg_name(const std::string& name) {
  const std::string extension = lower_extension(name);
  return extension == ".jpg" || extension == ".jpeg";
}

/// "left/a.bmp", "_front" -> "left/a_front.png".
std::string view_name(const std::string& name, const std::string& suffix) {
  const fs::path path(name);
  const bool keeps_format = is_jpeg_name(name) || lower_extension(name) == ".png";
  const std::string file = path.stem().string() + suffix + (keeps_format ? path.extension().string() : ".png");
  return (path.parent_path() / file).generic_string();
}

void check_names(const ExportViews& views) {
  std::set<std::string> names;
  for (const ExportView& view : views.views) {
    const fs::path path = fs::path(view.image.name).lexically_normal();
    if (path.is_absolute() || path.begin()->string() == "..") {
      throw Error(fmt::format("image '{}' would be written outside of the export", view.image.name));
    }
    if (!names.insert(view.image.name).second) {
      throw Error(fmt::format("two images would be called '{}' in the export", view.image.name));
    }
  }
}

}  // namespace

ExportViews recorded_views(const SparseModel& model, const std::vector<size_t>& images) {
  ExportViews views;
  views.cameras = model.cameras;
  for (const size_t i : images) {
    ExportView& view = views.views.emplace_back();
    view.source = i;
    view.image = model.images[i];
  }
  check_names(views);
  return views;
}

ExportViews undistorted_views(const SparseModel& model, const std::vector<size_t>& images,
                              const PinholeViewOptions& options) {
  std::map<uint32_t, std::vector<PinholeView>> views_of_camera;
  ExportViews views;
  bool one_each = true;
  for (const size_t i : images) {
    const uint32_t id = model.images[i].camera_id;
    if (views_of_camera.count(id) > 0) continue;
    const auto& made = views_of_camera.emplace(id, pinhole_views(model.cameras.at(id), options)).first->second;
    views.cameras.emplace(id, made.front().camera);
    one_each = one_each && made.size() == 1;
  }
  for (const size_t i : images) {
    const PosedImage& image = model.images[i];
    const Camera& camera = model.cameras.at(image.camera_id);
    for (const PinholeView& pinhole : views_of_camera.at(image.camera_id)) {
      ExportView& view = views.views.emplace_back();
      view.source = i;
      view.view_from_camera = pinhole.view_from_camera;
      const bool had_no_distortion =
          camera.model() == CameraModel::kPinhole || camera.model() == CameraModel::kSimplePinhole;
      view.is_resampled =
          !had_no_distortion || camera.width() != pinhole.camera.width() || camera.height() != pinhole.camera.height();
      view.image = image;
      if (!one_each) view.image.id = static_cast<uint32_t>(views.views.size());
      if (view.is_resampled) view.image.name = view_name(image.name, pinhole.suffix);
      view.image.camera_from_map = Rigid3(pinhole.view_from_camera, Eigen::Vector3d::Zero()) * image.camera_from_map;
    }
  }
  check_names(views);
  return views;
}

ExportImages::ExportImages(std::string directory, const SparseModel& model, const ExportViews& views)
    : directory_(std::move(directory)), model_(model), views_(views) {}

std::string ExportImages::source_path(const ExportView& view) const {
  return image_path(directory_, model_.images[view.source].name);
}

void ExportImages::load(const ExportView& view) {
  loaded_ = view.source;
  source_image_.reset();
  const uint32_t camera_id = model_.images[view.source].camera_id;
  const Camera& camera = model_.cameras.at(camera_id);
  try {
    source_image_ = read_color_image(source_path(view));
    if (source_image_->width != camera.width() || source_image_->height != camera.height()) {
      throw Error(fmt::format("{}: is {}x{}, its camera {} is {}x{}", source_path(view), source_image_->width,
                              source_image_->height, camera_id, camera.width(), camera.height()));
    }
  } catch (const Error& error) {
    source_image_.reset();
    log_warning(fmt::format("skipped: {}", error.what()));
  }
}

const ResampleTable& ExportImages::table_of(const ExportView& view) {
  const Eigen::Vector4d q = view.view_from_camera.coeffs();
  const auto key = std::make_pair(view.image.camera_id, std::vector<double>(q.data(), q.data() + 4));
  const auto found = tables_.find(key);
  if (found != tables_.end()) return found->second;
  const Camera& camera = model_.cameras.at(model_.images[view.source].camera_id);
  return tables_
      .emplace(key, make_resample_table(camera, views_.cameras.at(view.image.camera_id), view.view_from_camera))
      .first->second;
}

std::optional<ColorImage> ExportImages::read(const ExportView& view) {
  if (loaded_ != view.source) load(view);
  if (!source_image_ || !view.is_resampled) return source_image_;
  const Camera& camera = model_.cameras.at(model_.images[view.source].camera_id);
  return resample_image(*source_image_, table_of(view), camera.model() == CameraModel::kEquirectangular);
}

void ExportImages::write(const ExportView& view, const ColorImage& pixels, const std::string& path,
                         int jpeg_quality) const {
  if (view.is_resampled && is_jpeg_name(path)) return write_jpeg(path, pixels, jpeg_quality);
  if (view.is_resampled) return write_png(path, pixels);
  std::error_code failure;
  fs::create_directories(fs::path(path).parent_path(), failure);
  if (!failure) fs::copy_file(source_path(view), path, failure);
  if (failure) throw Error(fmt::format("{}: cannot copy it to {}: {}", source_path(view), path, failure.message()));
}

}  // namespace cpplus
