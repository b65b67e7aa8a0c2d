#include "cpplus/pipeline/upright_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cpplus {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Looks along the sensor's x axis with z up, then turned about the sensor's axes: yaw left, pitch down, roll.
Rigid3 mounted(double yaw, double pitch, double roll) {
  const Quaterniond forward(0.5, 0.5, -0.5, 0.5);
  const Quaterniond sensor_from_turned =
      AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) * AngleAxisd(roll, Vector3d::UnitX());
  return {forward * sensor_from_turned.conjugate(), Vector3d(0.1, -0.05, 0.02)};
}

std::vector<Rigid3> walk() {
  std::vector<Rigid3> poses;
  for (int i = 0; i < 9; ++i) {
    poses.push_back(
        {Quaterniond(AngleAxisd(0.4 * i, Vector3d::UnitZ()) * AngleAxisd(0.05, Vector3d::UnitY())), Vector3d(i, 0, 0)});
  }
  return poses;
}

UprightCheck check(const Rigid3& camera_from_sensor) {
  return check_upright(camera_from_sensor, walk(), Vector3d::UnitZ());
}

TEST(UprightCheck, RightExtrinsicsPass) {
  for (const double yaw : {0.0, 0.8, -1.6, 3.1}) {
    for (const double pitch : {0.0, 0.3, -0.4}) {
      const UprightCheck result = check(mounted(yaw, pitch, 0.1));
      EXPECT_FALSE(result.mistake) << yaw << " " << pitch << ": " << *result.mistake;
      EXPECT_LT(result.tilt_deg, 30.0);
    }
  }
  EXPECT_NEAR(check_upright(mounted(0, 0.3, 0), {Rigid3{}}, Vector3d::UnitZ()).tilt_deg, 0.3 * 180.0 / M_PI, 1e-9);
}

TEST(UprightCheck, AnInvertedExtrinsicIsRecognised) {
  for (const double yaw : {0.0, 0.3, -0.4}) {
    const UprightCheck result = check(inverse(mounted(yaw, 0.1, 0.05)));
    EXPECT_GT(result.tilt_deg, 60.0) << yaw;
    ASSERT_TRUE(result.mistake) << yaw;
    EXPECT_EQ(*result.mistake, "inverted");
    EXPECT_LT(result.corrected_tilt_deg, 15.0);
  }
}

TEST(UprightCheck, TheOrderOfAQuaternionIsRecognised) {
  const Quaterniond q = mounted(-1.57, 0.1, 0.0).rotation;
  const UprightCheck last = check(Rigid3(Quaterniond(q.x(), q.y(), q.z(), q.w()), Vector3d::Zero()));
  ASSERT_TRUE(last.mistake) << last.tilt_deg;
  EXPECT_THAT(*last.mistake, testing::HasSubstr("w last where w is read first"));
  const UprightCheck first = check(Rigid3(Quaterniond(q.z(), q.w(), q.x(), q.y()), Vector3d::Zero()));
  ASSERT_TRUE(first.mistake) << first.tilt_deg;
  EXPECT_THAT(*first.mistake, testing::HasSubstr("w first where w is read last"));
}

/// How often mistakes are recognised over mounts at any yaw, with some pitch and roll.
TEST(UprightCheck, RatesOverManyMounts) {
  int num_mounts = 0;
  int num_inverted = 0;
  int num_w_last = 0;
  int num_w_first = 0;
  for (int yaw_deg = -180; yaw_deg < 180; yaw_deg += 10) {
    for (const double pitch : {-0.4, -0.2, 0.0, 0.2, 0.4}) {
      for (const double roll : {-0.2, 0.0, 0.2}) {
        const Rigid3 right = mounted(yaw_deg * M_PI / 180.0, pitch, roll);
        const Quaterniond q = right.rotation;
        ++num_mounts;
        ASSERT_FALSE(check(right).mistake) << yaw_deg;
        ASSERT_FALSE(check(mounted(yaw_deg * M_PI / 180.0, M_PI / 4.0, roll)).mistake) << yaw_deg << " pitched";
        num_inverted += check(inverse(right)).mistake.has_value();
        num_w_last += check(Rigid3(Quaterniond(q.x(), q.y(), q.z(), q.w()), Vector3d::Zero())).mistake.has_value();
        num_w_first += check(Rigid3(Quaterniond(q.z(), q.w(), q.x(), q.y()), Vector3d::Zero())).mistake.has_value();
      }
    }
  }
  RecordProperty("mounts", num_mounts);
  RecordProperty("inverted", num_inverted);
  RecordProperty("w_last", num_w_last);
  RecordProperty("w_first", num_w_first);
  EXPECT_GT(num_inverted, num_mounts * 6 / 10);
  EXPECT_GT(num_w_last, num_mounts * 6 / 10);
  EXPECT_GT(num_w_first, num_mounts * 6 / 10);
}

TEST(UprightCheck, SaysNothingWhereNoMistakeExplainsIt) {
  const Rigid3 nearly_same_axes(Quaterniond(AngleAxisd(0.2, Vector3d::UnitX())), Vector3d(0.1, 0, 0));
  EXPECT_FALSE(check_upright(inverse(nearly_same_axes), {Rigid3{}}, -Vector3d::UnitY()).mistake);
  EXPECT_FALSE(check_upright(mounted(0, 0, 0), {}, Vector3d::UnitZ()).mistake);
}

}  // namespace
}  // namespace cpplus
