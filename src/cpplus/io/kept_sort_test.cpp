#include "cpplus/io/kept_sort.h"

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

/// Of 10 points with positions and indices alone, 16 bytes each.
SortedPoints ten_points() {
  SortedPoints sorted;
  sorted.outline.origin = {1.0, 2.0, 3.0};
  sorted.outline.num_points = 10;
  sorted.outline.num_dropped_non_finite = 4;
  sorted.outline.attributes = {false, false, false, false, false, false};
  sorted.outline.las_frame = LasFrame();
  sorted.outline.las_frame->scale = {0.5, 0.25, 0.125};
  sorted.num_roots = 3;
  sorted.bucket_sizes = {7, 3};
  return sorted;
}

class KeptSortTest : public FileTest {
 protected:
  /// Leaves ten sorted points as a run that is interrupted does.
  void sort_and_keep() const {
    KeptSort kept(target_, "a key");
    kept.file()->write(0, std::string(160, 'p').data(), 160);
    kept.finish(ten_points());
    kept.keep();
  }

  bool is_sorted(const std::string& key) const {
    KeptSort kept(target_, key);
    const bool is_sorted = kept.sorted().has_value();
    kept.keep();
    return is_sorted;
  }

  std::string target_ = path("map.vox");
};

TEST_F(KeptSortTest, WhatIsKeptIsThereForTheNextOneOfTheSameKey) {
  sort_and_keep();
  KeptSort kept(target_, "a key");
  ASSERT_TRUE(kept.sorted());
  EXPECT_EQ(kept.sorted()->outline.origin, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(kept.sorted()->outline.num_points, 10u);
  EXPECT_EQ(kept.sorted()->outline.num_dropped_non_finite, 4u);
  EXPECT_FALSE(kept.sorted()->outline.attributes.intensities);
  ASSERT_TRUE(kept.sorted()->outline.las_frame);
  EXPECT_EQ(kept.sorted()->outline.las_frame->scale, ten_points().outline.las_frame->scale);
  EXPECT_EQ(kept.sorted()->num_roots, 3u);
  EXPECT_EQ(kept.sorted()->bucket_sizes, (std::vector<uint64_t>{7, 3}));
  std::string bytes(160, ' ');
  kept.file()->read(0, bytes.data(), bytes.size());
  EXPECT_EQ(bytes, std::string(160, 'p'));
}

TEST_F(KeptSortTest, WhatIsNotKeptIsGone) {
  sort_and_keep();
  EXPECT_EQ(num_files(), 1u);
  { const KeptSort kept(target_, "a key"); }
  EXPECT_EQ(num_files(), 0u);
}

TEST_F(KeptSortTest, AnotherKeyThrowsItAway) {
  sort_and_keep();
  EXPECT_FALSE(is_sorted("b key"));
  EXPECT_FALSE(is_sorted("a key"));
}

TEST_F(KeptSortTest, WhatWasNotSortedToTheEndIsThrownAway) {
  {
    KeptSort kept(target_, "a key");
    kept.file()->write(0, "points", 6);
    kept.keep();
  }
  EXPECT_EQ(num_files(), 0u);
}

TEST_F(KeptSortTest, DamagedOnesAreThrownAway) {
  for (const char* name : {".map.vox.sorted/plan", ".map.vox.sorted/points"}) {
    sort_and_keep();
    EXPECT_TRUE(is_sorted("a key"));
    const std::string bytes = read(name);
    write(name, bytes.substr(0, bytes.size() - 1));
    EXPECT_FALSE(is_sorted("a key")) << name;
  }
  sort_and_keep();
  std::string plan = read(".map.vox.sorted/plan");
  plan.back() ^= 1;
  write(".map.vox.sorted/plan", plan);
  EXPECT_FALSE(is_sorted("a key"));
}

TEST_F(KeptSortTest, AFolderInThePlansPlaceIsThrownAway) {
  write(".map.vox.sorted/plan/some", "");
  EXPECT_FALSE(is_sorted("a key"));
  sort_and_keep();
  EXPECT_TRUE(is_sorted("a key"));
}

TEST_F(KeptSortTest, OneAtATime) {
  sort_and_keep();
  {
    const KeptSort first(target_, "a key");
    EXPECT_TRUE(first.sorted());
    const KeptSort second(target_, "a key");
    EXPECT_FALSE(second.sorted());
    const auto file = second.file();
    file->write(0, "other", 5);
    std::string bytes(5, ' ');
    first.file()->read(0, bytes.data(), 5);
    EXPECT_EQ(bytes, "ppppp");
  }
  EXPECT_EQ(num_files(), 0u);
}

}  // namespace
}  // namespace cpplus
