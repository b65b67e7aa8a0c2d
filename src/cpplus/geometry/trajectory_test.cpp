#include "cpplus/geometry/trajectory.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

StampedPose pose_at(double stamp_s, double x) {
  return {stamp_s, Rigid3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, 0, 0))};
}

TEST(OrderByStamp, GoodPosesStayAsTheyAre) {
  const OrderedTrajectory ordered = order_by_stamp({pose_at(1, 0), pose_at(1.1, 1), pose_at(1.25, 2)});
  ASSERT_EQ(ordered.trajectory.size(), 3u);
  EXPECT_EQ(ordered.num_out_of_order, 0u);
  EXPECT_EQ(ordered.num_double, 0u);
  EXPECT_TRUE(order_by_stamp({}).trajectory.empty());
  EXPECT_EQ(order_by_stamp({pose_at(3, 0)}).trajectory.size(), 1u);
}

TEST(OrderByStamp, LatePosesAreSortedInAndCounted) {
  const OrderedTrajectory ordered = order_by_stamp({pose_at(1, 0), pose_at(3, 3), pose_at(2, 2), pose_at(4, 4)});
  ASSERT_EQ(ordered.trajectory.size(), 4u);
  EXPECT_EQ(ordered.trajectory[1].map_from_sensor.translation.x(), 2);
  EXPECT_EQ(ordered.num_out_of_order, 1u);
  EXPECT_EQ(ordered.first_out_of_order_s, 2);
}

TEST(OrderByStamp, OfDoubleStampsTheFirstIsKept) {
  const OrderedTrajectory ordered = order_by_stamp(
      {pose_at(1, 0), pose_at(2, 1), pose_at(2, 9), pose_at(3, 2), pose_at(3.01, 9), pose_at(4, 3), pose_at(4.2, 4)});
  ASSERT_EQ(ordered.trajectory.size(), 5u);
  for (size_t i = 0; i < 5; ++i)
    EXPECT_EQ(ordered.trajectory[i].map_from_sensor.translation.x(), static_cast<double>(i));
  EXPECT_EQ(ordered.num_double, 2u);
  EXPECT_EQ(ordered.first_double_s, 2);
}

}  // namespace
}  // namespace cpplus
