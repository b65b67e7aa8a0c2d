#include "tiny_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "run_cpplus.h"

namespace cpplus {

namespace {

std::string wall_pcd() {
  constexpr int kColumns = 40;
  constexpr int kRows = 30;
  std::string pcd = fmt::format(
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {0}\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA ascii\n",
      kColumns * kRows);
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      pcd += fmt::format("{:.2f} {:.2f} 3\n", 0.05 * (column - kColumns / 2), 0.05 * (row - kRows / 2));
    }
  }
  return pcd;
}

ColorImage checkered(int width, int height) {
  ColorImage image(width, height, Rgb{200, 180, 160});
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if ((x / 8 + y / 8) % 2 == 0) image.at(x, y) = {40, 60, 80};
    }
  }
  return image;
}

}  // namespace

TinyScene::TinyScene(std::string directory) : directory_(std::move(directory)) {
  std::filesystem::create_directories(path("images"));
  std::filesystem::create_directories(path("model"));
  std::filesystem::create_directories(path("scans"));
  write("map.pcd", wall_pcd());
  for (const char* name : {"scans/0.pcd", "scans/1.pcd"}) write(name, wall_pcd());
  write("scans/poses.txt", "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n");
  write("model/cameras.txt", "1 PINHOLE 64 48 60 60 32 24\n");
  write("model/images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 0.1 0 0 1 b.png\n\n");
  write("model/points3D.txt", "");
  write("stamps.txt", "a.png 10.0\nb.png 10.5\n");
  write("trajectory.txt", "9 0 0 0 0 0 0 1\n10 0 0 0 0 0 0 1\n11 -0.2 0 0 0 0 0 1\n");
  write("rig.yaml",
        "cameras:\n  front:\n    {model: PINHOLE, width: 64, height: 48, params: [60, 60, 32, 24],\n"
        "     camera_from_lidar: {quaternion_wxyz: [0.5, 0.5, -0.5, 0.5], translation: [0, 0, 0]}}\n");
  for (const char* name : {"images/a.png", "images/b.png"}) write_png(path(name), checkered(64, 48));
}

void TinyScene::write(const std::string& name, const std::string& text) const { write_file(path(name), text); }
std::string TinyScene::read(const std::string& name) const { return read_file(path(name)); }

void TinyScene::replace(const std::string& name, const std::string& from, const std::string& to) const {
  std::string text = read(name);
  const size_t at = text.find(from);
  if (at == std::string::npos || text.find(from, at + 1) != std::string::npos) {
    throw std::logic_error(fmt::format("'{}' is not exactly once in {}", from, name));
  }
  write(name, text.replace(at, from.size(), to));
}

void TinyScene::truncate(const std::string& name, size_t size) const {
  if (std::filesystem::file_size(path(name)) <= size) throw std::logic_error(name + " is not longer");
  std::filesystem::resize_file(path(name), size);
}

void TinyScene::convert_map(const std::string& name) const {
  write_point_cloud(path(name), read_point_cloud(path("map.pcd")));
}

std::vector<std::string> TinyScene::colorize(const std::vector<std::string>& more) const {
  std::vector<std::string> arguments = {"colorize", "--map",       path("map.pcd"), "--images",     path("images"),
                                        "--poses",  path("model"), "--out",         path("out.ply")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

std::vector<std::string> TinyScene::refine(const std::vector<std::string>& more) const {
  std::vector<std::string> arguments = {"refine",  "--map",       path("map.pcd"), "--images", path("images"),
                                        "--poses", path("model"), "--out",         path("out")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

std::vector<std::string> TinyScene::clean(const std::vector<std::string>& more) const {
  std::vector<std::string> arguments = {"clean", "--scans",      path("scans"), "--poses", path("scans/poses.txt"),
                                        "--out", path("out.ply")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

std::vector<std::string> TinyScene::poses(const std::vector<std::string>& more) const {
  std::vector<std::string> arguments = {
      "poses",    "--trajectory",     path("trajectory.txt"), "--rig", path("rig.yaml"), "--images", path("images"),
      "--stamps", path("stamps.txt"), "--max-gap-s",          "1.5",   "--out",          path("out")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

std::vector<std::string> TinyScene::exports(const std::string& format, const std::vector<std::string>& more) const {
  std::vector<std::string> arguments = {"export",       "--format", format,        "--map", path("map.pcd"), "--images",
                                        path("images"), "--poses",  path("model"), "--out", path("out")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

std::vector<std::string> TinyScene::colorize_with(const std::string& flag, const std::string& value) const {
  return with_flag(colorize(), flag, value);
}

std::vector<std::string> with_flag(std::vector<std::string> arguments, const std::string& flag,
                                   const std::string& value) {
  const auto at = std::find(arguments.begin(), arguments.end(), flag);
  if (at == arguments.end()) {
    arguments.insert(arguments.end(), {flag, value});
  } else {
    *std::next(at) = value;
  }
  return arguments;
}

}  // namespace cpplus
