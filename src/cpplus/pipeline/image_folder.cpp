#include "cpplus/pipeline/image_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"

namespace cpplus {

namespace fs = std::filesystem;

bool has_image_extension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const std::set<std::string> known = {".jpg", ".jpeg", ".png", ".bmp", ".tif", ".tiff", ".webp", ".ppm", ".pgm"};
  return known.count(extension) > 0;
}

std::vector<std::string> list_images(const std::string& directory) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (entry.is_regular_file() && has_image_extension(entry.path().string())) {
      names.push_back(fs::relative(entry.path(), directory).generic_string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string image_path(const std::string& directory, const std::string& name) {
  return (fs::path(directory) / name).string();
}

std::string debug_image_name(const std::string& name) {
  std::string flat = fs::path(name).replace_extension(".png").generic_string();
  std::replace(flat.begin(), flat.end(), '/', '_');
  return flat;
}

ImageFolder find_images(const std::string& directory, const SparseModel& model) {
  if (!fs::is_directory(directory)) throw Error(fmt::format("{}: not a folder of images", directory));
  ImageFolder folder;
  std::set<std::string> named;
  for (size_t i = 0; i < model.images.size(); ++i) {
    const std::string& name = model.images[i].name;
    named.insert(fs::path(name).lexically_normal().generic_string());
    (fs::is_regular_file(image_path(directory, name)) ? folder.with_file : folder.missing).push_back(i);
  }
  for (const std::string& name : list_images(directory)) {
    if (named.count(name) == 0) folder.without_pose.push_back(name);
  }
  if (folder.with_file.empty()) {
    const std::string first =
        model.images.empty() ? "" : fmt::format(" (the first is '{}')", model.images.front().name);
    throw Error(fmt::format("{}: holds none of the model's {} images{}", directory, model.images.size(), first));
  }
  return folder;
}

void warn_of_unmatched(const std::string& directory, const SparseModel& model, const ImageFolder& folder) {
  const auto count = [](size_t n, const char* what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); };
  if (!folder.missing.empty()) {
    log_warning(fmt::format("{}: {} of the model not found, the first is '{}'", directory,
                            count(folder.missing.size(), "image"), model.images[folder.missing.front()].name));
  }
  if (!folder.without_pose.empty()) {
    log_warning(fmt::format("{}: {} without a pose not used, the first is '{}'", directory,
                            count(folder.without_pose.size(), "image"), folder.without_pose.front()));
  }
}

}  // namespace cpplus
