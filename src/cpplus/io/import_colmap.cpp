#include <fmt/format.h>

#include <filesystem>

#include "cpplus/core/error.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_stamps.h"
#include "cpplus/io/import_files.h"
#include "cpplus/io/imported_project.h"

namespace cpplus {

namespace fs = std::filesystem;

ImportedProject import_colmap(const std::string& folder) {
  ImportedProject project;
  for (const char* below : {"", "sparse/0", "sparse"}) {
    const fs::path candidate = fs::path(folder) / below;
    if (!fs::exists(candidate / "cameras.bin") && !fs::exists(candidate / "cameras.txt")) continue;
    project.model = read_sparse_model(candidate.string());
    break;
  }
  if (!project.model) throw Error(fmt::format("{}: no COLMAP model in it, in sparse/0 or in sparse", folder));
  if (fs::is_directory(fs::path(folder) / "images"))
    project.images = image_files((fs::path(folder) / "images").string());
  project.map = first_file(folder, {"map.pcd", "map.ply", "map.las"});
  const std::string stamps = first_file(folder, {"stamps.txt"});
  if (!stamps.empty()) project.stamps_s = read_image_stamps(stamps, StampUnit::kAuto);
  return project;
}

}  // namespace cpplus
