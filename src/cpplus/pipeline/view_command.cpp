#include "cpplus/pipeline/view_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/map_io.h"
#include "cpplus/pipeline/image_folder.h"
#include "cpplus/pipeline/refine_result.h"
#include "cpplus/pipeline/view_server.h"
#include "cpplus/report/shrink_image.h"
#include "cpplus/report/tile_set.h"
#include "cpplus/report/top_view.h"
#include "cpplus/report/view_page.h"
#include "cpplus/report/web_files.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 85;

std::string find_cloud(const std::string& given_folder, const RefineResult& result) {
  const fs::path parent = fs::absolute(result.folder).lexically_normal().parent_path();
  for (const fs::path& folder : {fs::path(given_folder), fs::path(result.folder), parent}) {
    for (const char* name : {"coloured", "colored"}) {
      for (const char* extension : {".ply", ".pcd", ".las", ".vox"}) {
        const fs::path path = folder / (name + std::string(extension));
        if (fs::is_regular_file(path)) return path.string();
      }
    }
  }
  log_warning(fmt::format("{}: no coloured.ply, .pcd, .las or .vox; showing the map without colours", given_folder));
  return result.inputs.map;
}

std::string fingerprint(const std::string& cloud) {
  if (!fs::is_regular_file(cloud)) throw Error(fmt::format("{}: no such file", cloud));
  return fmt::format("{}\n{}\n{}\n", fs::absolute(cloud).lexically_normal().string(), fs::file_size(cloud),
                     fs::last_write_time(cloud).time_since_epoch().count());
}

// What the tiles in a folder are of, besides the cloud: needed again when they are kept.
struct TileSetFacts {
  Eigen::Vector3d origin_in_map = Eigen::Vector3d::Zero();
  size_t num_points = 0;
};

std::string facts_text(const TileSetFacts& facts) {
  const Eigen::Vector3d& x = facts.origin_in_map;
  return fmt::format("{} {} {} {}\n", x.x(), x.y(), x.z(), facts.num_points);
}

// Tiles of an older cloud are removed, new ones written; those of this cloud are kept.
TileSetFacts ensure_tiles(const std::string& cloud_path, const std::string& folder) {
  const std::string marker = folder + "/tiles/made_of.txt";
  const std::string made_of = fingerprint(cloud_path);
  std::ifstream stream(marker, std::ios::binary);
  const std::string found{std::istreambuf_iterator<char>(stream), {}};
  TileSetFacts facts;
  if (found.starts_with(made_of)) {
    std::istringstream numbers(found.substr(made_of.size()));
    Eigen::Vector3d& x = facts.origin_in_map;
    if (numbers >> x.x() >> x.y() >> x.z() >> facts.num_points) return facts;
  }
  if (!found.empty()) fs::remove_all(folder + "/tiles");  // the marker says that they are ours
  const PointCloud cloud = read_map_cloud(cloud_path);
  facts = {tile_set_origin(cloud), cloud.size()};
  write_tile_set(cloud, facts.origin_in_map, folder);
  write_text_file(marker, made_of + facts_text(facts));
  return facts;
}

void write_page(const RefineResult& result, const TileSetFacts& facts, const std::string& folder) {
  ViewPage page;
  page.title = fs::absolute(result.folder).lexically_normal().string();
  page.report_json = result.report_json;
  page.coarse = result.coarse;
  page.refined = result.refined;
  page.origin_in_map = facts.origin_in_map;
  page.num_points = facts.num_points;
  std::vector<Rigid3> cameras_from_map;
  for (const PosedImage& image : result.coarse.images) cameras_from_map.push_back(image.camera_from_map);
  page.up = up_axis(cameras_from_map);
  const std::string script = view_page_script(page);
  write_web_files(view_web_files(), folder);
  write_text_file(folder + "/data.js", script);
}

std::vector<uint8_t> make_photo(const std::string& path, int size_px) {
  const ColorImage photo = read_color_image(path);
  return encode_jpeg(shrink_image(photo, shrink_factor(photo.width, photo.height, size_px)), kJpegQuality);
}

void export_photos(const RefineResult& result, const std::string& folder, int size_px) {
  const std::vector<std::string>& names = result.image_names;
  std::vector<std::string> problems(names.size());
  Progress progress("write photos", names.size());
  parallel_for_each(names.size(), [&](size_t i) {
    try {
      const std::vector<uint8_t> jpeg = make_photo(image_path(result.inputs.images, names[i]), size_px);
      write_text_file(folder + "/" + photo_path(i), std::string(jpeg.begin(), jpeg.end()));
    } catch (const Error& error) {
      problems[i] = error.what();
    }
    progress.advance();
  });
  for (const std::string& problem : problems) {
    if (!problem.empty()) log_warning("no photo: " + problem);
  }
}

}  // namespace

void ViewCommandOptions::validate() const {
  if (port < 0 || port > 65535) throw UsageError(fmt::format("option port must be in [0, 65535], got {}", port));
  if (photo_size_px < 64 || photo_size_px > 8192) {
    throw UsageError(fmt::format("option photo_size_px must be in [64, 8192], got {}", photo_size_px));
  }
}

void view_command(const std::string& result_folder, const ViewCommandOptions& options,
                  const std::function<void(const std::string& address)>& on_ready) {
  options.validate();
  const RefineResult result = read_refine_result(result_folder, {"", options.images, options.poses});
  const std::string folder = options.export_to.empty() ? result.folder + "/view" : options.export_to;
  const std::string cloud = options.cloud.empty() ? find_cloud(result_folder, result) : options.cloud;
  write_page(result, ensure_tiles(cloud, folder), folder);
  if (!options.export_to.empty()) {
    export_photos(result, folder, options.photo_size_px);
    on_ready(folder);
    return;
  }
  const std::vector<std::string>& names = result.image_names;
  serve_view(
      folder, options.port,
      [&](size_t i) -> std::vector<uint8_t> {
        if (i >= names.size()) return {};
        try {
          return make_photo(image_path(result.inputs.images, names[i]), options.photo_size_px);
        } catch (const Error& error) {
          log_warning(error.what());
          return {};
        }
      },
      on_ready);
}

}  // namespace cpplus
