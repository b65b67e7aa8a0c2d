#include "cpplus/colorize/view_sampler.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/colorize/cell_bearings.h"
#include "cpplus/core/error.h"

namespace cpplus {
namespace {

const Eigen::Vector3d kFacing(0, 0, -1);

/// A camera at the origin that looks at a wall 4 m away; the left half of the image is covered by something at 2 m.
/// One cell a pixel; 10 px a metre at 10 m.
ColorView half_covered_view() {
  ColorView view;
  view.name = "a.jpg";
  view.camera = Camera(CameraModel::kPinhole, 101, 81, {100.0, 100.0, 50.0, 40.0});
  view.image = ColorImage(101, 81, Rgb{200, 100, 50});
  view.depth.camera = view.camera;
  view.depth.cell_px = 1.0;
  view.depth.range = RangeImage(101, 81);
  for (int y = 0; y < 81; ++y) {
    for (int x = 0; x < 101; ++x) {
      const double z = x < 50 ? 2.0 : 4.0;
      view.depth.range.at(x, y) = static_cast<float>(z * Eigen::Vector3d((x - 50) / 100.0, (y - 40) / 100.0, 1).norm());
    }
  }
  return view;
}

/// The point at a depth that projects to a pixel of that camera.
Eigen::Vector3d point_at(double x_px, double y_px, double depth_m) {
  return depth_m * Eigen::Vector3d((x_px - 50) / 100.0, (y_px - 40) / 100.0, 1);
}

class ViewSamplerTest : public testing::Test {
 protected:
  ColorView view_ = half_covered_view();
  CellBearings bearings_;
  ViewSamplingOptions options_;
  std::optional<ViewSample> sample(const Eigen::Vector3d& x, const Eigen::Vector3d& normal = kFacing) {
    return ViewSampler(view_, bearings_.of(view_.depth), options_).sample(x, normal);
  }
};

TEST_F(ViewSamplerTest, SeesWhatIsInFrontAndNotWhatIsHidden) {
  ASSERT_TRUE(sample(point_at(80, 40, 4)));
  EXPECT_EQ(sample(point_at(80, 40, 4))->color, (Rgb{200, 100, 50}));
  EXPECT_TRUE(sample(point_at(20, 40, 2)));
  EXPECT_FALSE(sample(point_at(20, 40, 4)));
  EXPECT_FALSE(sample(point_at(80, 40, -4)));
}

TEST_F(ViewSamplerTest, ToleratesOnlyALittleDepthBehindTheSurface) {
  EXPECT_TRUE(sample(point_at(80, 40, 4.04)));
  EXPECT_FALSE(sample(point_at(80, 40, 4.10)));  // the far side of a thin wall
}

TEST_F(ViewSamplerTest, BackgroundNextToTheForegroundGivesNoColour) {
  EXPECT_FALSE(sample(point_at(52, 40, 4)));  // the foreground ends at x = 49.5
  EXPECT_TRUE(sample(point_at(56, 40, 4)));
}

TEST_F(ViewSamplerTest, TheForegroundsRimIsTrustedLess) {
  options_.reference_distance_m = 1e9;
  const auto rim = sample(point_at(47, 40, 2));
  const auto inside = sample(point_at(43, 40, 2));
  ASSERT_TRUE(rim && inside);
  EXPECT_LT(rim->weight, 0.3 * inside->weight);
}

TEST_F(ViewSamplerTest, AGrazingFloorIsNoEdgeWhereItsNormalIsKnown) {
  // A floor 0.2 m below the camera: at row 45 its range is 4 m, one row further down 3.34 m.
  for (int y = 0; y < 81; ++y) {
    for (int x = 0; x < 101; ++x) {
      const Eigen::Vector3d ray((x - 50) / 100.0, (y - 40) / 100.0, 1);
      view_.depth.range.at(x, y) = y > 40 ? static_cast<float>(0.2 / ray.y() * ray.norm()) : 0.0f;
    }
  }
  EXPECT_TRUE(sample(point_at(50, 45, 4), Eigen::Vector3d(0, 1, 0)));
  EXPECT_TRUE(sample(point_at(50, 45, 4), Eigen::Vector3d(0, -1, 0)));
  EXPECT_FALSE(sample(point_at(50, 45, 4), kFacing));
}

TEST_F(ViewSamplerTest, WeightFallsWithDistanceIncidenceAndTowardsTheCorners) {
  // At the reference distance a frontal sample weighs half of what it does close by.
  view_.depth.range = RangeImage(101, 81, 50.0f);
  options_.edge_jump_ratio = 1e6;
  options_.reference_distance_m = 5.0;
  EXPECT_NEAR(sample(point_at(50, 40, 5))->weight, 0.5, 1e-9);
  const Eigen::Vector3d tilted(std::sqrt(0.75), 0, 0.5);  // 60 degrees
  EXPECT_NEAR(sample(point_at(50, 40, 5), tilted)->weight, 0.25, 1e-9);
  EXPECT_NEAR(sample(point_at(50, 40, 5), Eigen::Vector3d::Zero())->weight, 0.25, 1e-9);
  // Four fifths of the way to the corner: 1 - 0.75 * 0.8^2.
  const Eigen::Vector3d outwards = point_at(10, 8, 1).normalized() * 5;
  EXPECT_NEAR(sample(outwards, outwards.normalized())->weight, 0.5 * 0.52, 1e-9);
}

TEST_F(ViewSamplerTest, WeightIsScaledByThatOfTheView) {
  const double whole = sample(point_at(80, 40, 4))->weight;
  view_.weight = 0.1;
  EXPECT_NEAR(sample(point_at(80, 40, 4))->weight, 0.1 * whole, 1e-12);
}

TEST_F(ViewSamplerTest, IgnoresTheBorderAndWhatIsTooFar) {
  EXPECT_FALSE(sample(point_at(97.5, 40, 4)));
  EXPECT_TRUE(sample(point_at(96.5, 40, 4)));
  options_.max_distance_m = 3.9;
  EXPECT_FALSE(sample(point_at(80, 40, 4)));
}

TEST_F(ViewSamplerTest, RejectsAnImageOfAnotherSizeThanItsCamera) {
  view_.image = ColorImage(100, 81);
  EXPECT_THROW(ViewSampler(view_, bearings_.of(view_.depth), options_), Error);
}

TEST_F(ViewSamplerTest, OptionsOutOfRangeAreRejected) {
  options_.occlusion_tolerance_m = 0;
  EXPECT_THROW(options_.validate(), Error);
}

TEST(ViewSampler, APanoramaIsSampledAcrossItsSeam) {
  ColorView view;
  view.name = "panorama";
  view.camera = Camera(CameraModel::kEquirectangular, 360, 180, {360.0, 180.0});
  view.image = ColorImage(360, 180, Rgb{10, 20, 30});
  view.depth.camera = view.camera;
  view.depth.wraps = true;
  view.depth.range = RangeImage(180, 90, 4.0f);
  for (int y = 0; y < 90; ++y) view.depth.range.at(0, y) = 2.0f;  // something near in the first column only
  const ViewSamplingOptions options;
  CellBearings bearings;
  const ViewSampler sampler(view, bearings.of(view.depth), options);
  const auto straight_behind = [](double degrees) {
    return Eigen::Vector3d(std::sin(M_PI - degrees * M_PI / 180), 0, std::cos(M_PI - degrees * M_PI / 180));
  };
  EXPECT_TRUE(sampler.sample(4 * straight_behind(20), -straight_behind(20)));
  EXPECT_FALSE(
      sampler.sample(4 * straight_behind(1.5), -straight_behind(1.5)));  // the near column is next, round the seam
}

TEST(Bilinear, MixesTheFourNeighboursByHand) {
  ColorImage image(2, 2);
  image.at(0, 0) = {0, 0, 0};
  image.at(1, 0) = {100, 0, 0};
  image.at(0, 1) = {0, 80, 0};
  image.at(1, 1) = {100, 80, 200};
  EXPECT_EQ(bilinear(image, {0.25, 0.5}), (Rgb{25, 40, 25}));
  EXPECT_EQ(bilinear(image, {1, 1}), (Rgb{100, 80, 200}));
  EXPECT_EQ(bilinear(image, {-3, 9}), (Rgb{0, 80, 0}));
}

}  // namespace
}  // namespace cpplus
