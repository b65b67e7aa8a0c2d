#include <cstring>
#include <utility>

#include "bad_input_cases.h"
#include "cpplus/io/index_point_clouds.h"
#include "cpplus/io/voxel_map_format.h"

namespace cpplus {
namespace {

using Arguments = std::vector<std::string>;

/// The bytes of the scene's map as a voxel map file.
std::string indexed_map(const TinyScene& scene) {
  index_point_clouds({scene.path("map.pcd")}, {}, size_t{1} << 20, scene.path("map.vox"));
  return scene.read("map.vox");
}

/// Colours DIR/map.vox after a change of its bytes.
template <typename Change>
BadInputCase colorize_changed(const Change& change) {
  return [=](const TinyScene& scene) {
    std::string bytes = indexed_map(scene);
    change(&bytes);
    scene.write("map.vox", bytes);
    return scene.colorize_with("--map", scene.path("map.vox"));
  };
}

/// `index` of DIR/FILE to DIR/OUT.
BadInputCase index_to(const std::string& file, const std::string& out, const Arguments& more = {}) {
  return [=](const TinyScene& scene) {
    Arguments arguments = {"index", scene.path(file), "--out", scene.path(out)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
}

Arguments info_of_changed_content(const TinyScene& scene) {
  std::string bytes = indexed_map(scene);
  VoxelMapSectionEntry positions;
  std::memcpy(&positions, bytes.data() + sizeof(VoxelMapHeader), sizeof(positions));
  bytes[positions.offset] ^= 1;
  scene.write("map.vox", bytes);
  return {"info", scene.path("map.vox")};
}

}  // namespace

std::map<std::string, BadInputCase> bad_voxel_map_cases() {
  return {
      {"voxel map does not exist",
       [](const TinyScene& scene) { return scene.colorize_with("--map", scene.path("none.vox")); }},
      {"voxel map that is another kind of file", colorize_changed([](std::string* bytes) { *bytes = "ply\n"; })},
      {"voxel map truncated", colorize_changed([](std::string* bytes) { bytes->resize(20000); })},
      {"voxel map of a newer version", colorize_changed([](std::string* bytes) { (*bytes)[12] = 9; })},
      {"voxel map of another byte order",
       colorize_changed([](std::string* bytes) { std::swap((*bytes)[8], (*bytes)[11]); })},
      {"voxel map with a damaged header", colorize_changed([](std::string* bytes) { (*bytes)[48] = 'x'; })},
      {"voxel map with damaged content", info_of_changed_content},
      {"voxel map of other voxels",
       [](const TinyScene& scene) {
         indexed_map(scene);
         return with_flag(scene.colorize_with("--map", scene.path("map.vox")), "--voxel-map.leaf-size-m", "0.125");
       }},
      {"map to index does not exist", index_to("none.pcd", "out/map.vox")},
      {"map to index is a voxel map", index_to("map.vox", "out/map.vox")},
      {"voxel map of unknown extension", index_to("map.pcd", "out/map.ply")},
      {"voxel map below a file", index_to("map.pcd", "map.pcd/map.vox")},
      {"index without an output",
       [](const TinyScene& scene) {
         return Arguments{"index", scene.path("map.pcd")};
       }},
      {"too little memory to index", index_to("map.pcd", "out/map.vox", {"--memory-mb", "1"})},
  };
}

}  // namespace cpplus
