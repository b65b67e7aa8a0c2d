#include "cpplus/io/import_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "cpplus/core/error.h"
#include "cpplus/io/file_info.h"

namespace cpplus {

namespace fs = std::filesystem;

std::string required_file(const std::string& folder, const std::string& name) {
  const fs::path path = fs::path(folder) / name;
  if (!fs::is_regular_file(path)) throw Error(fmt::format("{}: no such file", path.string()));
  return path.string();
}

std::string first_file(const std::string& folder, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const fs::path path = fs::path(folder) / name;
    if (fs::is_regular_file(path)) return path.string();
  }
  return "";
}

std::vector<std::string> files_with_extension(const std::string& folder, const std::string& extension) {
  std::vector<std::string> names;
  if (!fs::is_directory(folder)) return names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file() && entry.path().extension() == extension) {
      names.push_back(entry.path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<SourceFile> image_files(const std::string& folder) {
  if (!fs::is_directory(folder)) throw Error(fmt::format("{}: not a folder of images", folder));
  std::vector<SourceFile> images;
  for (const std::string& name : list_image_files(folder)) images.push_back({(fs::path(folder) / name).string(), name});
  if (images.empty()) throw Error(fmt::format("{}: holds no images", folder));
  return images;
}

SparseModel model_of_images(const Camera& camera, const std::vector<std::string>& names,
                            const std::vector<Rigid3>& camera_from_map) {
  SparseModel model;
  model.cameras.emplace(1, camera);
  for (size_t i = 0; i < names.size(); ++i) {
    model.images.push_back({static_cast<uint32_t>(i + 1), names[i], 1, camera_from_map[i]});
  }
  return model;
}

}  // namespace cpplus
