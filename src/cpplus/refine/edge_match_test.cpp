#include "cpplus/refine/edge_match.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

EdgeMatch match_of(uint32_t edge) {
  EdgeMatch match;
  match.edge = edge;
  return match;
}

TEST(CountEdges, CountsRunsOfTheSameEdge) {
  EXPECT_EQ(count_edges({}), 0);
  EXPECT_EQ(count_edges({match_of(4)}), 1);
  EXPECT_EQ(count_edges({match_of(0), match_of(0), match_of(3), match_of(7), match_of(7)}), 3);
}

TEST(EdgeInformation, ByHand) {
  // 3 px right of the edgel with a standard deviation of 2 px: 1.5. Cauchy's loss of scale 1.5 leaves it half.
  EdgeMatch match;
  match.normal = {1, 0};
  match.pixel = {100, 50};
  match.sigma_px = 2.0;
  match.weight = 0.25;
  match.projected.pixel = {103, 90};
  match.projected.d_pixel_d_delta(0, 1) = 40.0;
  match.projected.d_pixel_d_delta(0, 3) = -8.0;
  match.projected.d_pixel_d_delta(1, 4) = 1000.0;  // along the edge: says nothing
  const Matrix6d information = edge_information({match}, 1.5);
  EXPECT_NEAR(information(1, 1), 0.5 * 0.25 * 400.0, 1e-12);
  EXPECT_NEAR(information(3, 3), 0.5 * 0.25 * 16.0, 1e-12);
  EXPECT_NEAR(information(1, 3), 0.5 * 0.25 * -80.0, 1e-12);
  EXPECT_EQ(information(4, 4), 0.0);
  EXPECT_EQ(information, information.transpose());
  EXPECT_EQ(edge_information({match, match}, 1.5), Matrix6d(2.0 * information));
  EXPECT_EQ(edge_information({}, 1.5), Matrix6d::Zero());
}

}  // namespace
}  // namespace cpplus
