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
  std::vector<EdgeSample> samples = samples_in_view(room, test_camera(), true_view());

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

TEST(EdgeLikelihood, ItFallsAwayFromTheRightPose) {
  const RoomLikelihood room;
  const EdgeLikelihood likelihood = room.likelihood(100000);
  const double best = likelihood.log_ratio(Vector6d::Zero());
  EXPECT_GT(best, 0.0);
  EXPECT_LT(likelihood.log_ratio(perturbation()), best);
  EXPECT_LT(likelihood.log_ratio(3.0 * perturbation()), likelihood.log_ratio(perturbation()));
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
