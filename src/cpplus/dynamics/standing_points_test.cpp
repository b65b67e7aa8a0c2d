#include "cpplus/dynamics/standing_points.h"

#include <gtest/gtest.h>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

// Ground at z = 0 that two scans hit every 4 cm, and a leg that the first has above it, with points of a foot.
class StandingPoints : public testing::Test {
 protected:
  StandingPoints() {
    for (int scan = 0; scan < 2; ++scan) {
      for (int x = -10; x <= 10; ++x) {
        for (int y = -10; y <= 10; ++y) add({0.04f * x + 0.011f * scan, 0.04f * y, 0.0f});
      }
      if (scan == 0) {
        leg_ = add({0.01f, 0.01f, 0.2f});
        foot_ = add({0.01f, 0.02f, 0.061f});
        sole_ = add({0.02f, 0.01f, 0.02f});
        far_ = add({0.35f, 0.35f, 0.061f});
      } else {
        other_ = add({0.11f, 0.11f, 0.06f});
      }
      scans_.first_point.push_back(scans_.points.size());
      scans_.sensors_in_map.push_back({3.0, 0.0, 1.5});
    }
  }

  size_t add(const Eigen::Vector3f& point) {
    scans_.points.positions.push_back(point);
    return scans_.points.size() - 1;
  }

  // With the leaf of the leg dynamic.
  size_t label(std::vector<uint8_t>* labels) const {
    const VoxelMap map(scans_.points, {});
    std::vector<uint8_t> leaf_labels(map.num_nodes(map.leaf_layer()), 0);
    leaf_labels[*map.find_leaf(scans_.points.positions[leg_].cast<double>())] = 1;
    labels->assign(scans_.points.size(), 0);
    return label_standing_points(map, scans_, leaf_labels, 0.05, labels);
  }

  ScanSet scans_;
  size_t leg_ = 0, foot_ = 0, sole_ = 0, far_ = 0, other_ = 0;
};

TEST_F(StandingPoints, AFootBelowALegIsTheOnlyOne) {
  std::vector<uint8_t> labels;
  EXPECT_EQ(label(&labels), 1u);
  EXPECT_EQ(labels[foot_], 1);
  EXPECT_EQ(labels[sole_], 0) << "as low as the ground";
  EXPECT_EQ(labels[far_], 0) << "not beside the leg";
  EXPECT_EQ(labels[other_], 0) << "of a scan that has no leg there";
}

TEST_F(StandingPoints, BelowTheGroundAsSeenFromTheSensorNothingStands) {
  for (Eigen::Vector3d& sensor : scans_.sensors_in_map) sensor.z() = -1.5;
  std::vector<uint8_t> labels;
  EXPECT_EQ(label(&labels), 0u);
}

TEST_F(StandingPoints, OneThreadAndFourAgree) {
  std::vector<uint8_t> one, four;
  set_num_threads(1);
  label(&one);
  set_num_threads(4);
  label(&four);
  set_num_threads(0);
  EXPECT_EQ(one, four);
}

}  // namespace
}  // namespace cpplus
