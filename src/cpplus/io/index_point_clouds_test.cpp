#include "cpplus/io/index_point_clouds.h"

#include <cstring>

#include "cpplus/cloud/point_map.h"
#include "cpplus/core/interrupt.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"
#include "cpplus/io/map_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_files.h"
#include "cpplus/io/voxel_map_file.h"

namespace cpplus {
namespace {

using IndexPointCloudsTest = FileTest;

constexpr size_t kEnough = size_t{1} << 30;

/// Noisy walls and loose points about the middle, in random order, with intensity, colour and time.
PointCloud walls(size_t size, const Eigen::Vector3d& middle, uint64_t seed) {
  Random random(seed);
  PointCloud cloud;
  cloud.origin = middle.array().round();
  for (size_t i = 0; i < size; ++i) {
    Eigen::Vector3d x(random.uniform(-6, 7), random.uniform(-5, 5), random.uniform(-3, 4));
    if (i % 20 != 0) x[static_cast<int>(i % 3)] = 0.013 * random.normal();
    cloud.positions.push_back((x + middle - cloud.origin).cast<float>());
    cloud.intensities.push_back(static_cast<float>(random.below(1000)));
    cloud.colors.push_back({static_cast<uint8_t>(i), static_cast<uint8_t>(i >> 8), 7});
    cloud.stamps_s.push_back(1e-3 * static_cast<double>(i));
    cloud.num_views.push_back(static_cast<uint16_t>(random.below(9)));
    cloud.best_images.push_back(static_cast<uint32_t>(random.below(100)));
    cloud.color_spreads.push_back(static_cast<uint8_t>(random.below(256)));
  }
  return cloud;
}

/// The second cloud's points after the first's, about the first's origin; attributes that both have.
PointCloud joined(PointCloud a, const PointCloud& b) {
  const auto append = [](auto* to, const auto& from) {
    if (from.empty()) to->clear();
    if (!to->empty()) to->insert(to->end(), from.begin(), from.end());
  };
  for (const Eigen::Vector3f& x : b.positions) {
    a.positions.push_back((x.cast<double>() + (b.origin - a.origin)).cast<float>());
  }
  append(&a.intensities, b.intensities);
  append(&a.colors, b.colors);
  append(&a.stamps_s, b.stamps_s);
  append(&a.num_views, b.num_views);
  append(&a.best_images, b.best_images);
  append(&a.color_spreads, b.color_spreads);
  return a;
}

template <typename T>
void expect_same(std::span<const T> a, std::span<const T> b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  EXPECT_TRUE(a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0) << what;
}

/// Byte for byte.
void expect_same_maps(const PointMap& a, const PointMap& b) {
  EXPECT_EQ(a.map.origin(), b.map.origin());
  EXPECT_EQ(a.map.options().root_size_m, b.map.options().root_size_m);
  EXPECT_EQ(a.map.options().leaf_size_m, b.map.options().leaf_size_m);
  EXPECT_EQ(a.map.num_dropped(), b.map.num_dropped());
  EXPECT_EQ(a.num_dropped_non_finite, b.num_dropped_non_finite);
  expect_same(a.map.arrays().positions, b.map.arrays().positions, "positions");
  expect_same(a.map.arrays().input_indices, b.map.arrays().input_indices, "input indices");
  expect_same(a.map.arrays().root_keys, b.map.arrays().root_keys, "root keys");
  expect_same(a.map.arrays().root_table, b.map.arrays().root_table, "root table");
  ASSERT_EQ(a.map.num_layers(), b.map.num_layers());
  for (size_t l = 0; l < static_cast<size_t>(a.map.num_layers()); ++l) {
    const VoxelMapLayer& of_a = a.map.arrays().layers[l];
    const VoxelMapLayer& of_b = b.map.arrays().layers[l];
    const std::string layer = " of layer " + std::to_string(l);
    expect_same(of_a.first, of_b.first, "first" + layer);
    expect_same(of_a.child_mask, of_b.child_mask, "child masks" + layer);
    expect_same(of_a.moments_mask, of_b.moments_mask, "moments mask" + layer);
    expect_same(of_a.moments_rank, of_b.moments_rank, "moments rank" + layer);
    expect_same(of_a.moments, of_b.moments, "moments" + layer);
  }
  expect_same(a.intensities, b.intensities, "intensities");
  expect_same(a.colors, b.colors, "colours");
  expect_same(a.stamps_s, b.stamps_s, "stamps");
  expect_same(a.num_views, b.num_views, "views");
  expect_same(a.best_images, b.best_images, "best images");
  expect_same(a.color_spreads, b.color_spreads, "spreads");
}

TEST_F(IndexPointCloudsTest, EqualsTheMapInMemoryForAnyMemory) {
  const PointCloud cloud = walls(20000, {0.3, -0.2, 0.1}, 1);
  write_point_cloud(path("a.ply"), cloud);
  const PointMap in_memory = read_map(path("a.ply"), {});
  size_t most_buckets = 0;
  for (const size_t memory_bytes : {kEnough, size_t{1} << 20, size_t{100000}, size_t{1}}) {
    const IndexSummary summary = index_point_clouds({path("a.ply")}, {}, memory_bytes, path("a.vox"));
    EXPECT_EQ(summary.num_points, cloud.size());
    EXPECT_EQ(summary.num_roots, in_memory.map.num_nodes(0));
    EXPECT_EQ(summary.num_buckets == 1, memory_bytes == kEnough);
    most_buckets = std::max(most_buckets, summary.num_buckets);
    expect_same_maps(map_voxel_map_file(path("a.vox")), in_memory);
    EXPECT_NO_THROW(verify_voxel_map_file(path("a.vox")));
  }
  EXPECT_EQ(most_buckets, in_memory.map.num_nodes(0)) << "with no memory at all, each root is built alone";
  EXPECT_EQ(num_files(), 2u) << "temporaries are left";
}

TEST_F(IndexPointCloudsTest, EqualsTheMapInMemoryForOtherSizesOfVoxels) {
  write_point_cloud(path("a.ply"), walls(3000, {0.3, -0.2, 0.1}, 2));
  for (const auto& [root, leaf] : {std::pair(0.5, 0.5), {1.0, 0.5}, {4.0, 0.25}, {8.0, 0.0078125}}) {
    const VoxelMapOptions options = {root, leaf};
    index_point_clouds({path("a.ply")}, options, 20000, path("a.vox"));
    expect_same_maps(read_map(path("a.vox"), options), read_map(path("a.ply"), options));
  }
}

TEST_F(IndexPointCloudsTest, SeveralFilesAreOneAfterTheOther) {
  const Eigen::Vector3d munich(600000.4, 5000000.2, 500.0);
  PointCloud a = walls(3000, munich, 3);
  PointCloud b = walls(2500, munich + Eigen::Vector3d(5, 1, 0), 4);
  b.intensities.clear();
  b.num_views.clear();
  write_point_cloud(path("a.las"), a);
  write_point_cloud(path("b.pcd"), b);
  const PointCloud both = joined(read_point_cloud(path("a.las")), read_point_cloud(path("b.pcd")));
  EXPECT_NE(read_point_cloud(path("b.pcd")).origin, both.origin) << "the second is moved";
  ASSERT_TRUE(both.intensities.empty());
  index_point_clouds({path("a.las"), path("b.pcd")}, {}, 50000, path("both.vox"));
  const PointMap points = map_voxel_map_file(path("both.vox"));
  expect_same_maps(points, make_point_map(both, {}));
  ASSERT_TRUE(points.las_frame.has_value());
  EXPECT_EQ(points.las_frame->scale, both.las_frame->scale);
  const PointCloud back = read_map_cloud(path("both.vox"));
  EXPECT_EQ(back.positions, both.positions);
  EXPECT_EQ(back.stamps_s, both.stamps_s);
}

TEST_F(IndexPointCloudsTest, DoesNotDependOnTheNumberOfThreads) {
  write_point_cloud(path("a.ply"), walls(100000, {0.3, -0.2, 0.1}, 5));
  for (const int threads : {1, 2, 3}) {
    set_num_threads(threads);
    index_point_clouds({path("a.ply")}, {}, size_t{4} << 20, path(std::to_string(threads) + ".vox"));
  }
  set_num_threads(0);
  EXPECT_TRUE(read("1.vox") == read("2.vox"));
  EXPECT_TRUE(read("1.vox") == read("3.vox"));
}

TEST_F(IndexPointCloudsTest, PointsThatAreNotFiniteAreLeftOutAndCounted) {
  write("a.pcd",
        "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 1\nPOINTS 4\nDATA ascii\n"
        "5 5 5\nnan 1 1\n1 1 1\n1 1 inf\n");
  const IndexSummary summary = index_point_clouds({path("a.pcd"), path("a.pcd")}, {}, kEnough, path("a.vox"));
  EXPECT_EQ(summary.num_points, 4u);
  EXPECT_EQ(summary.num_dropped_non_finite, 4u);
  const PointMap points = map_voxel_map_file(path("a.vox"));
  EXPECT_EQ(points.num_dropped_non_finite, 4u);
  EXPECT_THAT(points.map.arrays().input_indices, testing::ElementsAre(1u, 3u, 0u, 2u));
}

TEST_F(IndexPointCloudsTest, FailuresLeaveNothingBehindAndTheOldFileAlone) {
  write("old.vox", "old");
  const std::string head =
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n";
  write("good.pcd", head + "1 2 3\n4 5 6\n");
  write("far.pcd", head + "1 2 3\n1e9 5 6\n");
  write("short.pcd", head + "1.0000 2.0000 3.0000\n");
  const auto index = [&](const std::string& name) {
    return index_point_clouds({path("good.pcd"), path(name)}, {}, kEnough, path("old.vox"));
  };
  EXPECT_ERROR(index("none.pcd"), "none.pcd: cannot read");
  EXPECT_ERROR(index("none.xyz"), "none.xyz: unknown point cloud extension '.xyz'");
  EXPECT_ERROR(index("short.pcd"), "short.pcd: truncated: 1 points");
  EXPECT_ERROR(index("far.pcd"), "far.pcd: point 3 at (1000000000, 5, 6) m is outside the voxel grid");
  EXPECT_ERROR(index_point_clouds({path("good.pcd")}, {}, kEnough, path("good.pcd") + "/a.vox"),
               "cannot make its folder");
  request_interrupt();
  EXPECT_THROW(index("good.pcd"), Interrupted);
  clear_interrupt();
  EXPECT_EQ(read("old.vox"), "old");
  EXPECT_EQ(num_files(), 4u);
}

}  // namespace
}  // namespace cpplus
