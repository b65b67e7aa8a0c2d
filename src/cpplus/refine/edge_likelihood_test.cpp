#include "cpplus/refine/edge_likelihood.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/refine/test_room.h"

namespace cpplus {
namespace {

struct RoomLikelihood {
  TestRoom room = furnished_room();
  ImageEdges image = draw_room(room, test_camera(), true_view(), {});
  DirectionalDistanceField field{image, 4, 24.0};
  std::vector<EdgeSample> samples = sample_visible_edges(room.edges, test_camera(), true_view(),
                                                         cast_plane_buffer(room, test_camera(), true_view()), {});

  EdgeLikelihood likelihood(int max_samples) const {
    EdgeLikelihood result(test_camera(), true_view(), room.edges, samples, field, max_samples);
    result.set_kernel(8.0);
    return result;
  }
};

Vector6d perturbation() {
  Vector6d delta;
  delta << 0.002, -0.003, 0.001, 0.01, 0.02, -0.01;
  return delta;
}

TEST(EdgeLikelihood, PartsAddUpToTheWholeAndEachTellsMostOfIt) {
  const RoomLikelihood room;
  const EdgeLikelihood likelihood = room.likelihood(100000);
  ASSERT_EQ(likelihood.num_parts(), 4u);
  for (const Vector6d& delta : {Vector6d(Vector6d::Zero()), perturbation()}) {
    const double whole = likelihood.log_ratio(delta);
    double sum = 0.0;
    for (size_t part = 0; part < 4; ++part) {
      const double of_part = likelihood.log_ratio_of_part(delta, part);
      EXPECT_NEAR(of_part, 0.25 * whole, 0.1 * std::abs(whole)) << part;
      sum += of_part;
    }
    EXPECT_NEAR(sum, whole, 1e-4 * std::abs(whole));
  }
}

TEST(EdgeLikelihood, FewSamplesAreOnePart) {
  const RoomLikelihood room;
  const EdgeLikelihood likelihood = room.likelihood(100);
  ASSERT_EQ(likelihood.num_parts(), 1u);
  EXPECT_EQ(likelihood.log_ratio_of_part(perturbation(), 0), likelihood.log_ratio(perturbation()));
}

TEST(EdgeLikelihood, WithoutSamplesItIsChance) {
  const RoomLikelihood room;
  EdgeLikelihood likelihood(test_camera(), true_view(), {}, {}, room.field, 100);
  likelihood.set_kernel(8.0);
  EXPECT_TRUE(likelihood.empty());
  EXPECT_EQ(likelihood.log_ratio(perturbation()), 0.0);
}

}  // namespace
}  // namespace cpplus
