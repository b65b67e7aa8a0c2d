#include "cpplus/refine/nid_pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"
#include "cpplus/refine/test_room.h"

namespace cpplus {
namespace {

constexpr double kLattice = 0.12;  // metres between the random values of the texture

double lattice_value(int i, int j) {
  return Random(uint64_t{1000003} * static_cast<uint64_t>(i + 5000) + static_cast<uint64_t>(j + 5000)).uniform();
}

// Random values in [0, 1] on a lattice in the plane z = 0, bilinear between them.
double texture(double x, double y) {
  const double u = x / kLattice;
  const double v = y / kLattice;
  const int i = static_cast<int>(std::floor(u));
  const int j = static_cast<int>(std::floor(v));
  const double s = u - i;
  const double t = v - j;
  return (1 - t) * ((1 - s) * lattice_value(i, j) + s * lattice_value(i + 1, j)) +
         t * ((1 - s) * lattice_value(i, j + 1) + s * lattice_value(i + 1, j + 1));
}

// A floor seen from 2 m above, looking down at a slant; what is bright to the LiDAR is dark to the camera.
class NidPose : public testing::Test {
 protected:
  NidPose() : camera_(test_camera()), true_pose_(look_at({0, 0, 2.0}, {1.2, 0.9, 0})) {
    image_ = GrayImage(camera_.width(), camera_.height());
    const Rigid3 map_from_camera = inverse(true_pose_);
    for (int y = 0; y < camera_.height(); ++y) {
      for (int x = 0; x < camera_.width(); ++x) {
        const Eigen::Vector3d ray = map_from_camera.rotation * *camera_.unproject({x, y});
        if (ray.z() > -0.05) continue;
        const Eigen::Vector3d hit = map_from_camera.translation - map_from_camera.translation.z() / ray.z() * ray;
        const double value = texture(hit.x(), hit.y());
        image_.at(x, y) = static_cast<uint8_t>(std::lround(230 - 200 * value * value));
      }
    }
    Random random(5);
    std::vector<float> intensities;
    for (int i = 0; i < 30000; ++i) {
      const Eigen::Vector3d x(random.uniform(-3, 6), random.uniform(-4, 5), 0);
      points_.push_back({x, 0.0f});
      intensities.push_back(static_cast<float>(40 + 90 * texture(x.x(), x.y())));
    }
    const std::vector<float> equalised = equalise_intensities(intensities);
    for (size_t i = 0; i < points_.size(); ++i) points_[i].intensity = equalised[i];
  }

  ~NidPose() override { set_num_threads(0); }

  std::vector<NidPoint> visible(const Rigid3& pose) const {
    std::vector<NidPoint> seen;
    for (const NidPoint& point : points_) {
      const auto pixel = camera_.project(pose * point.x_in_map);
      if (pixel && camera_.in_image(*pixel, 2.0)) seen.push_back(point);
    }
    return seen;
  }

  NidResult refine(const Rigid3& coarse, const NidOptions& options) const {
    return refine_pose_nid(
        camera_, coarse, image_, [this](const Rigid3& pose) { return visible(pose); }, options);
  }

  Camera camera_;
  Rigid3 true_pose_;
  GrayImage image_;
  std::vector<NidPoint> points_;
};

TEST(Nid, OfSignalsThatGiveEachOtherIsZeroAndOfIndependentOnesOne) {
  Eigen::MatrixXd swapped = Eigen::MatrixXd::Zero(3, 3);
  swapped(0, 2) = 5;
  swapped(1, 0) = 2;
  swapped(2, 1) = 1;
  EXPECT_NEAR(normalised_information_distance(swapped), 0.0, 1e-12);
  const Eigen::Vector3d a(1, 2, 3);
  const Eigen::Vector3d b(4, 1, 1);
  EXPECT_NEAR(normalised_information_distance(a * b.transpose()), 1.0, 1e-12);
}

TEST(Nid, ByHand) {
  // Shares 1/2, 1/4, 1/4: H(X,Y) = 1.5 bit, H(X) = 1 bit, H(Y) = 2 - 3/4 log2 3 = 0.811 bit.
  Eigen::MatrixXd joint(2, 2);
  joint << 2, 0, 1, 1;
  EXPECT_NEAR(normalised_information_distance(joint), (3.0 - 1.0 - (2.0 - 0.75 * std::log2(3.0))) / 1.5, 1e-12);
}

TEST(Nid, WithoutInformationIsOne) {
  EXPECT_EQ(normalised_information_distance(Eigen::MatrixXd::Zero(4, 4)), 1.0);
  Eigen::MatrixXd one_bin = Eigen::MatrixXd::Zero(4, 4);
  one_bin(1, 2) = 7;
  EXPECT_EQ(normalised_information_distance(one_bin), 1.0);
}

TEST(EqualiseIntensities, AreTheSharesOfLowerValues) {
  const std::vector<float> equalised =
      equalise_intensities({30.0f, 10.0f, 1000.0f, 10.0f, std::numeric_limits<float>::quiet_NaN()});
  ASSERT_EQ(equalised.size(), 5u);
  EXPECT_FLOAT_EQ(equalised[0], 0.625f);
  EXPECT_FLOAT_EQ(equalised[1], 0.25f);
  EXPECT_FLOAT_EQ(equalised[2], 0.875f);
  EXPECT_FLOAT_EQ(equalised[3], 0.25f);
  EXPECT_TRUE(std::isnan(equalised[4]));
}

TEST_F(NidPose, DistanceIsLowAtTheTruthAndNearOneForOtherTextures) {
  const std::vector<NidPoint> seen = visible(true_pose_);
  ASSERT_GT(seen.size(), 3000u);
  const double at_truth = nid_at(seen, camera_, true_pose_, image_, 16);
  std::vector<NidPoint> shuffled = seen;
  for (size_t i = 0; i < seen.size(); ++i) shuffled[i].intensity = seen[(i + seen.size() / 2) % seen.size()].intensity;
  EXPECT_LT(at_truth, 0.75);
  EXPECT_GT(nid_at(shuffled, camera_, true_pose_, image_, 16), 0.97);
}

TEST_F(NidPose, ComesHomeFromHalfADegreeAndThreeCentimetres) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const Rigid3 coarse = disturbed(true_pose_, 0.5, 0.03, seed);
    const NidResult result = refine(coarse, {});
    ASSERT_TRUE(result.improved) << result.reason;
    EXPECT_LT(result.after, result.before);
    EXPECT_LT(rotation_angle_between(result.camera_from_map, true_pose_), 0.1 * std::numbers::pi / 180.0) << seed;
    EXPECT_LT((camera_center(result.camera_from_map) - camera_center(true_pose_)).norm(), 0.005) << seed;
  }
}

TEST_F(NidPose, FewPointsKeepTheCoarsePose) {
  points_.resize(100);
  const Rigid3 coarse = disturbed(true_pose_, 0.5, 0.03, 1);
  const NidResult result = refine(coarse, {});
  EXPECT_FALSE(result.improved);
  EXPECT_EQ(result.reason, "too few map points in view");
  EXPECT_EQ(result.camera_from_map.translation, coarse.translation);
}

TEST_F(NidPose, OneThreadAndThreeFindTheSameBits) {
  NidOptions options;
  options.rounds = 1;
  options.max_evaluations = 40;
  const auto run = [&](int threads) {
    set_num_threads(threads);
    std::vector<Vector6d> found(4);
    parallel_for_each(found.size(), [&](size_t i) {
      found[i] =
          camera_difference(true_pose_, refine(disturbed(true_pose_, 0.5, 0.03, i + 1), options).camera_from_map);
    });
    return found;
  };
  EXPECT_EQ(run(1), run(3));
}

TEST(NidOptions, OutOfRangeIsNamed) {
  NidOptions options;
  EXPECT_NO_THROW(options.validate());
  options.bins = 1;
  EXPECT_THROW(options.validate(), Error);
}

}  // namespace
}  // namespace cpplus
