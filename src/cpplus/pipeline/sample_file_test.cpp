#include "cpplus/pipeline/sample_file.h"

#include <gtest/gtest.h>

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

class SampleFiles : public FileTest {};

TEST_F(SampleFiles, GiveBackTheSamplesOfEachRoot) {
  ColorSamples samples(3, 2);
  samples.add(0, {{1, 2, 3}, 50, 700, 9});
  samples.add(2, {{10, 20, 30}, 50, 1, 0});
  samples.add(2, {{11, 21, 31}, 60, 2, 8});
  samples.add(2, {{12, 22, 32}, 70, 3, 7});
  SampleFile file(path("map.ply"), 5, 2);
  file.add(3, samples, 0, 1);
  file.add(1, samples, 1, 3);
  const ColorSamples first = file.read(3);
  ASSERT_EQ(first.num_points(), 1u);
  ASSERT_EQ(first.of_point(0).size(), 1u);
  EXPECT_EQ(first.of_point(0)[0].image, 700);
  EXPECT_EQ(first.of_point(0)[0].radius, 9);
  const ColorSamples second = file.read(1);
  ASSERT_EQ(second.num_points(), 2u);
  EXPECT_TRUE(second.of_point(0).empty());
  EXPECT_EQ(second.num_views(0), 0);
  EXPECT_EQ(second.num_views(1), 3);
  ASSERT_EQ(second.of_point(1).size(), 2u);
  EXPECT_EQ(second.of_point(1)[0].image, 2);
  EXPECT_EQ(second.of_point(1)[1].color, (Rgb{12, 22, 32}));
  EXPECT_EQ(file.read(0).num_points(), 0u);
}

}  // namespace
}  // namespace cpplus
