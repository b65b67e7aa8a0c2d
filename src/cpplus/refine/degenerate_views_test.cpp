// The catalogue of docs/degenerate_views.md: views in which edges cannot determine all of a pose.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cpplus/refine/degeneracy.h"
#include "cpplus/refine/refine_pose.h"
#include "cpplus/refine/test_room.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

// Looks along the x axis of the map; camera x is -y of the map, camera y is -z, camera z is x.
Rigid3 true_pose() { return look_at({0, 0, 0}, {1, 0, 0}); }
Camera camera() { return Camera(CameraModel::kPinhole, 640, 480, {400, 400, 319.5, 239.5}); }

// Edges that nothing hides.
class World {
 public:
  void add(const Vector3d& start, const Vector3d& end) {
    MapEdge edge;
    edge.kind = MapEdgeKind::kIntensity;
    edge.start = start;
    edge.end = end;
    edge.group = static_cast<uint32_t>(room_.edges.size());
    edge.covariance = 4e-6 * Eigen::Matrix3d::Identity();
    room_.edges.push_back(edge);
  }

  // A rectangle in the plane x = distance.
  void add_panel(double distance, double y, double z, double width, double height) {
    const Vector3d a(distance, y, z), b(distance, y + width, z), c(distance, y + width, z + height),
        d(distance, y, z + height);
    add(a, b);
    add(b, c);
    add(c, d);
    add(d, a);
  }

  struct Outcome {
    RefinePoseResult result;
    double before_px = 0.0;
    double after_px = 0.0;
    Vector6d error;  // of the candidate: rad, m, camera frame
  };

  // From a pose that is wrong by `start`.
  Outcome refine(const Vector6d& start, double reach_m = 40.0) const {
    const RefinePoseOptions options;
    EdgeSampleOptions sampling;
    sampling.max_distance_m = reach_m;
    DrawnNoise noise;
    noise.edge_sigma_px = 0.3;
    const ImageEdges image_edges = draw_room(room_, camera(), true_pose(), noise);
    const Rigid3 coarse = perturb_camera(true_pose(), start);
    const PlaneBuffer nothing = cast_plane_buffer(TestRoom(), camera(), coarse);
    const std::vector<EdgeSample> samples = sample_visible_edges(room_.edges, camera(), coarse, nothing, sampling);
    Outcome outcome;
    outcome.result =
        refine_pose(camera(), coarse, {coarse, options.prior.sigmas()}, room_.edges, samples, image_edges, options);
    outcome.before_px = mean_shift_px(room_, camera(), true_pose(), coarse);
    outcome.after_px = mean_shift_px(room_, camera(), true_pose(), outcome.result.camera_from_map);
    outcome.error = camera_difference(true_pose(), outcome.result.candidate_camera_from_map);
    return outcome;
  }

 private:
  TestRoom room_;
};

Vector6d some_start() {
  Vector6d start;
  start << 0.006, -0.005, 0.004, 0.02, -0.03, 0.04;
  return start;
}

World panels_on_one_wall() {
  World world;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 3; ++j) world.add_panel(4.0, -2.4 + 1.2 * i, -1.6 + 1.1 * j, 0.5 + 0.13 * i, 0.4 + 0.11 * j);
  }
  return world;
}

World lines_along(int axis) {
  World world;
  Random random(4);
  for (int k = 0; k < 24; ++k) {
    Vector3d middle(random.uniform(2.0, 6.0), 0, 0);
    middle.y() = random.uniform(-0.6, 0.6) * middle.x();
    middle.z() = random.uniform(-0.4, 0.4) * middle.x();
    world.add(middle - 1.5 * Vector3d::Unit(axis), middle + 1.5 * Vector3d::Unit(axis));
  }
  return world;
}

World bare_corridor() {
  World world;
  for (const double y : {-1.0, 1.0}) {
    for (const double z : {-1.4, -1.3, 1.2, 1.3}) world.add({1.0, y, z}, {40.0, y, z});
  }
  return world;
}

World far_facade() {
  World world;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 4; ++j) world.add_panel(120.0, -70.0 + 25.0 * i, -40.0 + 22.0 * j, 9.0 + i, 8.0 + j);
  }
  return world;
}

// Vertical bars 20 cm apart between two rails; `half_count` of them to either side.
World fence(int half_count) {
  World world;
  const double half_m = 0.2 * half_count;
  for (int k = -half_count; k <= half_count; ++k) world.add({4.0, 0.2 * k, -1.0}, {4.0, 0.2 * k, 1.0});
  for (const double z : {-1.0, 1.0}) world.add({4.0, -half_m, z}, {4.0, half_m, z});
  return world;
}

// Components of the start that the edges cannot see stay as they were.
void expect_prior_along(Eigen::Index component, const Vector6d& start, const World::Outcome& outcome) {
  EXPECT_NEAR(outcome.error(component), start(component), 0.05 * std::abs(start(component)));
}

TEST(DegenerateViews, OneWallWithPictures) {
  // Two plane views of one wall differ by rotation and translation almost alike, but not quite.
  const World::Outcome o = panels_on_one_wall().refine(some_start());
  EXPECT_EQ(o.result.status, RefineStatus::kRefined) << o.result.reason;
  EXPECT_THAT(o.result.weak_directions, IsEmpty());
  EXPECT_GT(o.result.information_eigenvalues(0), 5.0);
  EXPECT_LT(o.result.information_eigenvalues(0), 0.01 * o.result.information_eigenvalues(5));
  EXPECT_LT(o.after_px, 0.5);
}

TEST(DegenerateViews, ParallelEdgesAlone) {
  const World::Outcome o = lines_along(2).refine(some_start());
  EXPECT_THAT(o.result.weak_directions, ElementsAre("translation y"));
  EXPECT_NEAR(o.result.information_eigenvalues(0), 0.0, 1e-6);
  EXPECT_GT(o.result.information_eigenvalues(1), 5.0);
  expect_prior_along(4, some_start(), o);
  EXPECT_LT(o.error.head<3>().norm(), 2e-3) << "what they do tell is used";
  EXPECT_LT(o.after_px, o.before_px);
}

TEST(DegenerateViews, BareCorridor) {
  const World::Outcome o = bare_corridor().refine(some_start());
  EXPECT_THAT(o.result.weak_directions, ElementsAre("translation z"));
  EXPECT_NEAR(o.result.information_eigenvalues(0), 0.0, 1e-6);
  expect_prior_along(5, some_start(), o);
  EXPECT_LT(o.error.segment<2>(3).norm(), 0.005);
  EXPECT_LT(o.error.head<3>().norm(), 2e-3);
  // Its covariance along the axis is the prior's.
  EXPECT_NEAR(std::sqrt(o.result.covariance(5, 5)), PosePrior().translation_sigma_m, 1e-3);
}

TEST(DegenerateViews, AllEdgesFarAway) {
  const World::Outcome o = far_facade().refine(some_start(), 200.0);
  EXPECT_THAT(o.result.weak_directions,
              UnorderedElementsAre(HasSubstr("translation x"), HasSubstr("translation y"), HasSubstr("translation z")));
  for (Eigen::Index k = 3; k < 6; ++k) EXPECT_NEAR(o.error(k), some_start()(k), 0.02) << k;
  EXPECT_LT(o.error.head<3>().norm(), 1.5e-3);
  EXPECT_LT(o.after_px, 0.5);
}

TEST(DegenerateViews, FewEdges) {
  World world;
  world.add_panel(4.0, -1.0, -0.5, 1.0, 1.0);
  const World::Outcome o = world.refine(some_start());
  EXPECT_EQ(o.result.status, RefineStatus::kKeptCoarse);
  EXPECT_EQ(o.result.reason, "too few matched edges");
  EXPECT_EQ(o.after_px, o.before_px);
}

TEST(DegenerateViews, RepeatedStructureOneStepOffWithItsEndInView) {
  Vector6d step = Vector6d::Zero();
  step(3) = 0.2;
  const World::Outcome o = fence(12).refine(step);
  EXPECT_EQ(o.result.status, RefineStatus::kRefined) << o.result.reason;
  EXPECT_NEAR(o.before_px, 20.0, 0.1);
  EXPECT_LT(o.after_px, 1.0);
}

TEST(DegenerateViews, RepeatedStructureThatFillsTheView) {
  // Nothing tells one bar from the next: a start within half a step comes home, one that is a step off stays there, and
  // neither the information nor the verdict can know. Other images can (joint solve).
  Vector6d step = Vector6d::Zero();
  step(3) = 0.06;
  EXPECT_LT(fence(40).refine(step).after_px, 1.0);
  step(3) = 0.2;
  const World::Outcome o = fence(40).refine(step);
  EXPECT_GT(o.after_px, 15.0);
  EXPECT_LT(o.after_px, 25.0);
  EXPECT_THAT(o.result.weak_directions, Not(Contains(HasSubstr("translation x"))));
}

TEST(DegenerateViews, UnitsOfTranslationDoNotChangeTheVerdict) {
  // Metres or millimetres: a mixed matrix has other eigenvalues, one in units of the prior has not.
  const Matrix6d information = bare_corridor().refine(some_start()).result.information;
  const Vector6d sigmas = PosePrior().sigmas();
  Vector6d unit = Vector6d::Ones();
  unit.tail<3>() *= 1000.0;
  const Matrix6d in_mm = unit.cwiseInverse().asDiagonal() * information * unit.cwiseInverse().asDiagonal();
  const Degeneracy metres = analyse_information(information, sigmas);
  const Degeneracy millimetres = analyse_information(in_mm, sigmas.cwiseProduct(unit));
  EXPECT_LT((metres.eigenvalues - millimetres.eigenvalues).norm(), 1e-6 * metres.eigenvalues.norm());
  EXPECT_EQ(metres.weak_directions, millimetres.weak_directions);
}

}  // namespace
}  // namespace cpplus
