#include "cpplus/simulate/board_views.h"

#include <algorithm>
#include <limits>

namespace cpplus {
namespace {

bool nothing_before(const Tracer& tracer, const BodyPoses& bodies, const Eigen::Vector3d& eye,
                    const Eigen::Vector3d& corner) {
  const Eigen::Vector3d ray = corner - eye;
  const auto hit = tracer.trace(eye.cast<float>(), ray.normalized().cast<float>(), bodies);
  return hit && hit->range > ray.norm() - 0.01 && hit->normal.dot(ray.cast<float>()) < 0.0f;
}

double min_spacing(const SceneCheckerboard& board, const std::vector<Eigen::Vector2d>& corners) {
  double nearest = std::numeric_limits<double>::max();
  const auto columns = static_cast<size_t>(board.inner_columns);
  for (size_t i = 0; i < corners.size(); ++i) {
    if (i % columns + 1 < columns) nearest = std::min(nearest, (corners[i + 1] - corners[i]).norm());
    if (i + columns < corners.size()) nearest = std::min(nearest, (corners[i + columns] - corners[i]).norm());
  }
  return nearest;
}

}  // namespace

std::vector<BoardView> find_board_views(const Tracer& tracer, const Renderer& renderer, const Camera& camera,
                                        const Shot& shot, size_t image) {
  constexpr double kMarginPx = 4.0;
  const BodyPoses bodies = body_poses(tracer.scene(), shot.stamp_s);
  const Eigen::Vector3d eye = camera_center(renderer.camera_from_map(shot.stamp_s));
  std::vector<BoardView> views;
  for (size_t b = 0; b < tracer.scene().boards.size(); ++b) {
    const SceneCheckerboard& board = tracer.scene().boards[b];
    BoardView view;
    view.board = b;
    view.image = image;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& corner : board.corners) {
      const auto pixel = renderer.project(shot, corner);
      if (!pixel || !camera.in_image(*pixel, kMarginPx) || !nothing_before(tracer, bodies, eye, corner)) break;
      view.corners_px.push_back(*pixel);
      middle += corner / static_cast<double>(board.corners.size());
    }
    if (view.corners_px.size() != board.corners.size()) continue;
    view.min_spacing_px = min_spacing(board, view.corners_px);
    view.distance_m = (middle - eye).norm();
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace cpplus
