#include "cpplus/visibility/hidden_ranges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace cpplus {
namespace {

Camera pinhole() { return Camera(CameraModel::kPinhole, 640, 480, {400, 400, 319.5, 239.5}); }

// A plane 4 m away that fills the left half of the image.
PlaneBuffer half_hidden() {
  PlaneBuffer planes;
  planes.camera = pinhole();
  planes.range_bound = RangeImage(160, 120, std::numeric_limits<float>::max());
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 80; ++x) planes.range_bound.at(x, y) = 4.0f;
  }
  return planes;
}

bool hides(const PlaneBuffer& planes, const Eigen::Vector3f& x, float radius_m = 0.05f) {
  const auto pixel = pinhole().project(x.cast<double>());
  const Eigen::Vector2f at = pixel ? Eigen::Vector2f(pixel->cast<float>()) : Eigen::Vector2f::Constant(NAN);
  return HiddenRanges(planes).hides(at, x.norm(), radius_m);
}

TEST(HiddenRanges, WhatLiesClearlyBehindPlanesIsHidden) {
  const PlaneBuffer planes = half_hidden();
  EXPECT_TRUE(hides(planes, {-3, 0, 8}));
  EXPECT_FALSE(hides(planes, {-1.5, 0, 4.0}));  // 0.27 m behind: within the margin
  EXPECT_FALSE(hides(planes, {-1.0, 0, 3}));
  EXPECT_FALSE(hides(planes, {3, 0, 8}));
}

TEST(HiddenRanges, NothingIsHiddenNearTheRimOfAPlaneNorOutsideTheImage) {
  const PlaneBuffer planes = half_hidden();
  EXPECT_FALSE(hides(planes, {-0.2f, 0, 8}));  // 10 px from the rim
  EXPECT_TRUE(hides(planes, {-1.6f, 0, 8}));   // 80 px
  EXPECT_FALSE(hides(planes, {-10, 0, 8}));
  EXPECT_FALSE(hides(planes, {0, 0, -8}));
  EXPECT_FALSE(hides(PlaneBuffer(), {-3, 0, 8}));
}

TEST(HiddenRanges, LargeNodesAreHiddenFartherFromTheRimAndTheImagesBorder) {
  const PlaneBuffer planes = half_hidden();
  EXPECT_TRUE(hides(planes, {-3.4f, 0, 8}, 0.8f));  // 60 px large, 170 px from the rim
  EXPECT_TRUE(hides(planes, {-0.8f, 0, 8}, 0.1f));
  EXPECT_FALSE(hides(planes, {-0.8f, 0, 8}, 0.8f));
  EXPECT_FALSE(hides(planes, {-2, 0, 4.4f}, 0.8f));  // reaches as near as the plane
  EXPECT_FALSE(hides(planes, {-3, 0, 8}, 3.0f));     // larger than all blocks
  EXPECT_FALSE(HiddenRanges().hides({10, 10}, 100.0f, 0.1f));
}

}  // namespace
}  // namespace cpplus
