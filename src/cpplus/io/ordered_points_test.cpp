#include "cpplus/io/ordered_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "cpplus/core/random.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

class OrderedPointsTest : public FileTest {};

constexpr size_t kPoints = 600000;  // more than two blocks

/// Points numbered by their place in the input, with all attributes but colours.
PointCloud numbered_points(const std::vector<uint32_t>& indices) {
  PointCloud cloud;
  for (const uint32_t k : indices) {
    cloud.positions.emplace_back(0.25f * static_cast<float>(k), 1.0f, -2.0f);
    cloud.intensities.push_back(0.5f * static_cast<float>(k));
    cloud.stamps_s.push_back(1e-3 * k);
    cloud.num_views.push_back(static_cast<uint16_t>(k));
    cloud.best_images.push_back(7 * k);
    cloud.color_spreads.push_back(static_cast<uint8_t>(k));
  }
  return cloud;
}

PointAttributes without_colors() {
  PointAttributes attributes;
  attributes.colors = false;
  return attributes;
}

std::vector<uint32_t> shuffled(size_t size) {
  std::vector<uint32_t> indices(size);
  std::iota(indices.begin(), indices.end(), 0u);
  Random random(5);
  for (size_t i = size - 1; i > 0; --i) {
    std::swap(indices[i], indices[static_cast<size_t>(random.uniform(0.0, static_cast<double>(i)))]);
  }
  return indices;
}

TEST_F(OrderedPointsTest, ComeBackInTheOrderOfTheInputAndAsOftenAsWanted) {
  OrderedPoints ordered("map.vox", path("out.pcd"), kPoints, without_colors());
  const std::vector<uint32_t> indices = shuffled(kPoints);
  for (size_t first = 0; first < kPoints; first += 7000) {
    const size_t size = std::min<size_t>(7000, kPoints - first);
    const std::vector<uint32_t> some(indices.begin() + static_cast<std::ptrdiff_t>(first),
                                     indices.begin() + static_cast<std::ptrdiff_t>(first + size));
    ordered.add(numbered_points(some), some);
  }
  const CloudStream stream = ordered.finish({10.0, 20.0, 30.0}, LasFrame());
  EXPECT_EQ(stream.num_points, kPoints);
  std::vector<uint32_t> order(kPoints);
  std::iota(order.begin(), order.end(), 0u);
  const PointCloud expected = numbered_points(order);
  for (int pass = 0; pass < 2; ++pass) {
    size_t first = 0;
    stream.for_each_block([&](const PointCloud& block) {
      EXPECT_EQ(block.origin, Eigen::Vector3d(10.0, 20.0, 30.0));
      EXPECT_TRUE(block.las_frame.has_value());
      EXPECT_TRUE(block.colors.empty());
      ASSERT_LE(first + block.size(), kPoints);
      for (size_t i = 0; i < block.size(); ++i) {
        ASSERT_EQ(block.positions[i], expected.positions[first + i]);
        ASSERT_EQ(block.intensities[i], expected.intensities[first + i]);
        ASSERT_EQ(block.stamps_s[i], expected.stamps_s[first + i]);
        ASSERT_EQ(block.num_views[i], expected.num_views[first + i]);
        ASSERT_EQ(block.best_images[i], expected.best_images[first + i]);
        ASSERT_EQ(block.color_spreads[i], expected.color_spreads[first + i]);
      }
      first += block.size();
    });
    EXPECT_EQ(first, kPoints);
  }
}

TEST_F(OrderedPointsTest, FilesOfBlocksAreThoseOfTheWholeCloud) {
  std::vector<uint32_t> order(kPoints);
  std::iota(order.begin(), order.end(), 0u);
  PointCloud cloud = numbered_points(order);
  OrderedPoints ordered("map.vox", path("out.pcd"), kPoints, without_colors());
  ordered.add(cloud, order);
  for (const double origin : {0.0, 5000.0}) {
    cloud.origin = {origin, 0.0, 0.0};
    const CloudStream stream = ordered.finish(cloud.origin, std::nullopt);
    for (const char* name : {"a.pcd", "a.ply", "a.las"}) {
      write_point_cloud(path(name), stream);
      write_point_cloud(path(std::string("whole_") + name), cloud);
      EXPECT_TRUE(read(name) == read(std::string("whole_") + name)) << name << " " << origin;
    }
  }
}

TEST_F(OrderedPointsTest, IndicesThatAreNotThoseOfThePointsAreRefused) {
  const std::string what = "map.vox: damaged: the indices of the map's points";
  const auto order = [&](const std::vector<uint32_t>& indices) {
    OrderedPoints ordered("map.vox", path("out.pcd"), 3, without_colors());
    ordered.add(numbered_points(indices), indices);
    ordered.finish({0, 0, 0}, std::nullopt).for_each_block([](const PointCloud&) {});
  };
  EXPECT_NO_THROW(order({2, 0, 1}));
  EXPECT_ERROR(order({2, 0, 3}), what);
  EXPECT_ERROR(order({2, 0, 0}), what);
  EXPECT_ERROR(order({2, 0}), what);
  EXPECT_ERROR(order({2, 0, 1, 1}), what);
}

}  // namespace
}  // namespace cpplus
