#include "cpplus/evaluate/checkerboard_residual.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

const Camera kCamera(CameraModel::kPinhole, 600, 800, {500.0, 500.0, 300.0, 400.0});

// Corners at (0,0,5) and (1,0,5) project to (300,400) and (400,400).
std::vector<Checkerboard> one_board(std::vector<Eigen::Vector2d> corner_pixels) {
  return {{"A", {{0, 0, 5}, {1, 0, 5}}, {{"a.jpg", std::move(corner_pixels)}}}};
}

TEST(CheckerboardResidual, IsTheMeanDistanceByHand) {
  EXPECT_NEAR(checkerboard_residual_px(one_board({{303, 404}, {400, 401}}), "a.jpg", kCamera, {}), 3.0, 1e-9);
}

TEST(CheckerboardResidual, AveragesOverTheCornersOfAllBoards) {
  std::vector<Checkerboard> boards = one_board({{300, 400}, {400, 400}});
  boards.push_back({"B", {{0, 0, 10}}, {{"b.jpg", {{0, 0}}}, {"a.jpg", {{300, 406}}}}});
  EXPECT_NEAR(checkerboard_residual_px(boards, "a.jpg", kCamera, {}), 2.0, 1e-9);
}

TEST(CheckerboardResidual, OfABoardBehindTheCameraIsTheDiagonal) {
  const Rigid3 moved_past{Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, -7)};
  EXPECT_NEAR(checkerboard_residual_px(one_board({{300, 400}, {400, 400}}), "a.jpg", kCamera, moved_past), 1000.0,
              1e-9);
}

TEST(CheckerboardResidual, IsNanWhereNoBoardIsSighted) {
  EXPECT_TRUE(std::isnan(checkerboard_residual_px(one_board({{300, 400}, {400, 400}}), "b.jpg", kCamera, {})));
}

TEST(CheckerboardResidual, RejectsAWrongNumberOfCorners) {
  EXPECT_THROW(checkerboard_residual_px(one_board({{300, 400}}), "a.jpg", kCamera, {}), Error);
}

}  // namespace
}  // namespace cpplus
