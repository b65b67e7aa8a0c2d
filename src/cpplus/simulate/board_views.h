#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/simulate/renderer.h"
#include "cpplus/simulate/tracer.h"

namespace cpplus {

/// A checkerboard that an image shows whole.
struct BoardView {
  size_t board = 0;  // index in Scene::boards
  size_t image = 0;
  std::vector<Eigen::Vector2d> corners_px;  // in the order of the board's corners; top-left pixel centre = (0, 0)
  double min_spacing_px = 0.0;              // between neighbouring corners
  double distance_m = 0.0;                  // camera to the middle of the board
};

/// The boards of one image whose inner corners all lie at least 4 px inside it with nothing before them.
std::vector<BoardView> find_board_views(const Tracer& tracer, const Renderer& renderer, const Camera& camera,
                                        const Shot& shot, size_t image);

}  // namespace cpplus
