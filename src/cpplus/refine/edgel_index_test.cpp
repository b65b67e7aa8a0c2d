#include "cpplus/refine/edgel_index.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

ImageEdgel edgel(double x, double y, double angle_deg) {
  const double angle = angle_deg * std::numbers::pi / 180.0;
  ImageEdgel e;
  e.pixel = Eigen::Vector2d(x, y).cast<float>();
  e.normal = Eigen::Vector2d(std::cos(angle), std::sin(angle)).cast<float>();
  e.gradient = 10.0f;
  return e;
}

ImageEdges image_of(std::vector<ImageEdgel> edgels) {
  ImageEdges edges;
  edges.width = 64;
  edges.height = 48;
  edges.edgels = std::move(edgels);
  return edges;
}

constexpr double kMaxAngleDeg = 15.0;

TEST(EdgelIndex, FindsTheNearestAlongTheNormal) {
  // Vertical edges (normals along x) at x = 13.7 and x = 26.2; the query lies at x = 19: 5.3 and 7.2 px away.
  const ImageEdges edges = image_of({edgel(13.7, 20, 0), edgel(26.2, 20, 180)});
  const EdgelIndex index(edges, kMaxAngleDeg);
  EXPECT_EQ(index.nearest_along({19, 20}, {1, 0}, 8.0), 0u);
  EXPECT_EQ(index.nearest_along({19, 20}, {-1, 0}, 8.0), 0u);
  EXPECT_EQ(index.nearest_along({20.5, 20}, {1, 0}, 8.0), 1u);
  EXPECT_FALSE(index.nearest_along({19, 20}, {1, 0}, 5.0));
  EXPECT_FLOAT_EQ(index.edgel(1).pixel.x(), 26.2f);
}

TEST(EdgelIndex, RefusesCrossingLines) {
  // The nearest edgel runs across at 40 degrees, the one behind it along.
  const ImageEdges edges = image_of({edgel(22, 20, 40), edgel(24, 20, 10)});
  const EdgelIndex index(edges, kMaxAngleDeg);
  EXPECT_EQ(index.nearest_along({20, 20}, {1, 0}, 8.0), 1u);
  EXPECT_EQ(EdgelIndex(edges, 60.0).nearest_along({20, 20}, {1, 0}, 8.0), 0u);
  EXPECT_FALSE(index.nearest_along({20, 20}, {0, 1}, 8.0));
}

TEST(EdgelIndex, DoesNotLookAlongTheEdge) {
  const ImageEdges edges = image_of({edgel(20, 26, 0)});
  const EdgelIndex index(edges, kMaxAngleDeg);
  EXPECT_FALSE(index.nearest_along({20, 20}, {1, 0}, 8.0));
}

TEST(EdgelIndex, ADiagonalChainIsNotSlippedThrough) {
  std::vector<ImageEdgel> chain;
  for (int i = 0; i < 30; ++i) chain.push_back(edgel(10 + i, 10 + i, -45));
  const ImageEdges edges = image_of(chain);
  const EdgelIndex index(edges, kMaxAngleDeg);
  const Eigen::Vector2d normal = Eigen::Vector2d(1, -1).normalized();
  for (double offset = -6; offset <= 6; offset += 0.1) {
    const Eigen::Vector2d pixel = Eigen::Vector2d(25, 25) + offset * normal;
    ASSERT_TRUE(index.nearest_along(pixel, normal, 7.0)) << offset;
  }
}

TEST(EdgelIndex, AgreesUpToTheAngleInAllDirections) {
  for (const double max_angle_deg : {3.0, 15.0, 40.0, 85.0}) {
    for (double angle_deg = 0.0; angle_deg < 360.0; angle_deg += 7.3) {
      const ImageEdges edges = image_of({edgel(20, 20, angle_deg)});
      const EdgelIndex index(edges, max_angle_deg);
      const auto is_found = [&](double off_deg) {
        const double angle = (angle_deg + off_deg) * std::numbers::pi / 180.0;
        std::vector<uint32_t> found;
        index.all_along({20, 20}, {std::cos(angle), std::sin(angle)}, 3.0, &found);
        return !found.empty();
      };
      for (const int side : {-1, 1}) {
        EXPECT_TRUE(is_found(side * (max_angle_deg - 0.01))) << angle_deg << " " << max_angle_deg;
        EXPECT_FALSE(is_found(side * (max_angle_deg + 0.01))) << angle_deg << " " << max_angle_deg;
        EXPECT_TRUE(is_found(180.0 + side * (max_angle_deg - 0.01))) << angle_deg << " " << max_angle_deg;
      }
    }
  }
}

TEST(EdgelIndex, OutsideTheImageThereIsNothing) {
  const ImageEdges edges = image_of({edgel(1, 1, 0)});
  const EdgelIndex index(edges, kMaxAngleDeg);
  EXPECT_FALSE(index.nearest_along({-40, 1}, {1, 0}, 8.0));
  EXPECT_FALSE(index.nearest_along({500, 500}, {1, 0}, 8.0));
  EXPECT_EQ(index.nearest_along({-3, 1}, {1, 0}, 8.0), 0u);
}

TEST(DirectionalDistanceField, ABinIsAnEighthOfHalfATurnAndThatOfTheOppositeNormal) {
  for (double angle = 0.2; angle < 180; angle += 0.7) {
    const double a = angle * std::numbers::pi / 180.0;
    const Eigen::Vector2d normal(std::cos(a), std::sin(a));
    const int bin = DirectionalDistanceField::bin_of(normal);
    EXPECT_EQ(bin, static_cast<int>(angle / 180.0 * DirectionalDistanceField::kBins)) << angle;
    EXPECT_EQ(bin, DirectionalDistanceField::bin_of(-normal));
  }
  EXPECT_EQ(DirectionalDistanceField::bin_of({-1, 0}), DirectionalDistanceField::bin_of({1, 0}));
}

TEST(DirectionalDistanceField, IsTheDistanceToTheNearestEdgelOfThatDirection) {
  // The chamfer metric overestimates by up to 8.3 %, the grid rounds both ends to the middle of a cell. An edgel surely
  // counts in its own bin and surely not beyond the neighbouring ones.
  Random random(7);
  std::vector<ImageEdgel> edgels;
  for (int i = 0; i < 60; ++i) {
    edgels.push_back(edgel(random.uniform(0, 63), random.uniform(0, 47), random.uniform(0, 360)));
  }
  const ImageEdges edges = image_of(edgels);
  constexpr int kBins = DirectionalDistanceField::kBins;
  for (const int cell_px : {1, 2, 4}) {
    const double max_distance = 20.0;
    const DirectionalDistanceField field(edges, cell_px, max_distance);
    EXPECT_FLOAT_EQ(field.max_distance(), 20.0f);
    const double rounding = 1.42 * cell_px;
    for (int query = 0; query < 2000; ++query) {
      const Eigen::Vector2d pixel(random.uniform(0, 63), random.uniform(0, 47));
      const int bin = static_cast<int>(random.below(kBins));
      double own = max_distance, near = max_distance;
      for (const ImageEdgel& e : edges.edgels) {
        const double distance = (e.pixel.cast<double>() - pixel).norm();
        const int away = std::abs(DirectionalDistanceField::bin_of(e.normal.cast<double>()) - bin);
        if (away == 0) own = std::min(own, distance);
        if (std::min(away, kBins - away) <= 1) near = std::min(near, distance);
      }
      const double found = static_cast<double>(field.distance(pixel.cast<float>(), bin));
      ASSERT_LE(found, std::min(max_distance, 1.083 * (own + rounding)) + 1e-4) << pixel.transpose();
      ASSERT_GE(found, near - rounding - 1e-4) << pixel.transpose();
    }
  }
}

TEST(DirectionalDistanceField, OutsideTheImageItIsTheLargest) {
  const ImageEdges edges = image_of({edgel(0, 0, 5), edgel(63, 47, 5)});
  const DirectionalDistanceField field(edges, 4, 12.0);
  const int bin = DirectionalDistanceField::bin_of(edges.edgels[0].normal.cast<double>());
  EXPECT_FLOAT_EQ(field.distance({0, 0}, bin), 0.0f);
  EXPECT_FLOAT_EQ(field.distance({-1, 0}, bin), 12.0f);
  EXPECT_FLOAT_EQ(field.distance({0, 100}, bin), 12.0f);
  EXPECT_FLOAT_EQ(field.distance({1e9f, 0}, bin), 12.0f);
}

TEST(DirectionalDistanceField, AnImageWithoutEdgesIsFarEverywhere) {
  const DirectionalDistanceField field(image_of({}), 4, 9.0);
  for (int bin = 0; bin < DirectionalDistanceField::kBins; ++bin) EXPECT_FLOAT_EQ(field.distance({30, 20}, bin), 9.0f);
}

}  // namespace
}  // namespace cpplus
