#include "cpplus/pipeline/checkerboard_json.h"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

using nlohmann::json;

template <int Size>
std::vector<Eigen::Matrix<double, Size, 1>> vectors_of(const json& list) {
  std::vector<Eigen::Matrix<double, Size, 1>> vectors;
  for (const json& entry : list) {
    if (entry.size() != Size) throw Error(fmt::format("expected {} numbers, got {}", Size, entry.size()));
    const auto numbers = entry.get<std::array<double, Size>>();
    vectors.push_back(Eigen::Map<const Eigen::Matrix<double, Size, 1>>(numbers.data()));
  }
  return vectors;
}

Checkerboard board_of(const json& entry) {
  Checkerboard board;
  board.name = entry.at("name").get<std::string>();
  board.corners_in_map = vectors_of<3>(entry.at("corners_3d"));
  for (const auto& [image_name, sighting] : entry.at("images").items()) {
    std::vector<Eigen::Vector2d> pixels = vectors_of<2>(sighting.at("corners_2d"));
    if (pixels.size() != board.corners_in_map.size()) {
      throw Error(
          fmt::format("image {} has {} corners, the board {}", image_name, pixels.size(), board.corners_in_map.size()));
    }
    for (Eigen::Vector2d& pixel : pixels) pixel.array() -= 0.5;
    board.sightings.push_back({image_name, std::move(pixels)});
  }
  return board;
}

}  // namespace

std::vector<Checkerboard> read_checkerboards(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error(fmt::format("{}: cannot be opened", path));
  std::vector<Checkerboard> boards;
  try {
    const json document = json::parse(file);
    for (const json& entry : document.at("boards")) boards.push_back(board_of(entry));
  } catch (const std::exception& error) {
    throw Error(fmt::format("{}: board {}: {}", path, boards.size(), error.what()));
  }
  return boards;
}

}  // namespace cpplus
