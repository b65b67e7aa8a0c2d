#include "cpplus/pipeline/image_sequences.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

// Four images: cameras 1, 2, 1, 1. Image i stands at x = i.
SparseModel model() {
  SparseModel model;
  const uint32_t cameras[] = {1, 2, 1, 1};
  for (int i = 0; i < 4; ++i) {
    PosedImage image;
    image.name = std::string(1, static_cast<char>('a' + i));
    image.camera_id = cameras[i];
    image.camera_from_map = Rigid3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(-i, 0, 0));
    model.images.push_back(image);
  }
  return model;
}

using Sequence = std::vector<std::pair<double, size_t>>;

TEST(ImageSequences, WithoutStampsThePlaceInTheModelIsTheTime) {
  const ImageSequences sequences = image_sequences(model(), {});
  ASSERT_EQ(sequences.size(), 2u);
  EXPECT_EQ(sequences.at(1), (Sequence{{0, 0}, {2, 2}, {3, 3}}));
  EXPECT_EQ(sequences.at(2), (Sequence{{1, 1}}));
}

TEST(ImageSequences, StampsGiveTheOrderAndImagesWithoutOneAreLeftOut) {
  const ImageSequences sequences = image_sequences(model(), {{"a", 7.5}, {"d", 2.0}, {"b", 5.0}, {"other", 1.0}});
  ASSERT_EQ(sequences.size(), 2u);
  EXPECT_EQ(sequences.at(1), (Sequence{{2.0, 3}, {7.5, 0}}));
  EXPECT_EQ(sequences.at(2), (Sequence{{5.0, 1}}));
  EXPECT_TRUE(image_sequences(model(), {{"other", 1.0}}).empty());
  EXPECT_TRUE(image_sequences({}, {}).empty());
}

TEST(ImageVelocities, ComeFromTheCoarsePosesOfTheSameCamera) {
  // a, c and d of camera 1 in steps of half a second: 4 m/s from a to c, 2 m/s from c to d, on a parabola.
  const std::map<std::string, double> stamps = {{"a", 0.0}, {"b", 0.2}, {"c", 0.5}, {"d", 1.0}};
  const ImageSequences sequences = image_sequences(model(), stamps);
  const auto velocities = image_velocities(model(), sequences, true, {});
  ASSERT_EQ(velocities.size(), 4u);
  ASSERT_TRUE(velocities[0] && velocities[3]);
  EXPECT_NEAR((*velocities[0])(3), 5.0, 0.01);
  EXPECT_NEAR((*velocities[3])(3), 1.0, 0.01);
  EXPECT_LT(velocities[0]->head<3>().norm(), 1e-9);
  EXPECT_FALSE(velocities[1]) << "one image alone has no velocity";
}

TEST(ImageVelocities, ComeFromTheTrajectoryWhereThereIsOne) {
  Trajectory trajectory;
  for (int k = 0; k < 4; ++k) {
    trajectory.push_back({0.1 * k, Rigid3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0.3 * k, 0))});
  }
  const std::map<std::string, double> stamps = {{"a", 0.15}, {"b", 0.2}, {"c", 5.0}};
  const auto velocities = image_velocities(model(), image_sequences(model(), stamps), true, trajectory);
  ASSERT_TRUE(velocities[0] && velocities[1]);
  EXPECT_NEAR((*velocities[0])(4), 3.0, 1e-9);
  EXPECT_NEAR((*velocities[1])(4), 3.0, 1e-9);
  EXPECT_FALSE(velocities[2]) << "outside the trajectory";
  EXPECT_FALSE(velocities[3]) << "no stamp";
}

TEST(ImageVelocities, NothingWithoutStamps) {
  for (const auto& velocity : image_velocities(model(), image_sequences(model(), {}), false, {})) {
    EXPECT_FALSE(velocity);
  }
}

TEST(ImageVelocities, TwoImagesOfOneInstantAreNoDivisionByZero) {
  const std::map<std::string, double> stamps = {{"a", 1.0}, {"c", 1.0}, {"d", 2.0}};
  const auto velocities = image_velocities(model(), image_sequences(model(), stamps), true, {});
  for (size_t i : {0, 2, 3}) {
    ASSERT_TRUE(velocities[i]) << i;
    EXPECT_TRUE(velocities[i]->allFinite()) << i;
  }
}

}  // namespace
}  // namespace cpplus
