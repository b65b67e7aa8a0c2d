#include "cpplus/adjust/pose_equations.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

Vector3d random_vector(Random* random) { return {random->normal(), random->normal(), random->normal()}; }

/// Patches of all directions that every scan sees, displaced by `error_m`.
std::vector<WeightedPatch> make_patches(size_t num_scans, double error_m) {
  Random random(7);
  std::vector<WeightedPatch> patches(12);
  for (WeightedPatch& patch : patches) {
    const Vector3d normal = random_vector(&random).normalized();
    const Vector3d center = 5.0 * random_vector(&random);
    for (uint32_t scan = 0; scan < num_scans; ++scan) {
      ScanCluster cluster{scan, 20.0, center + error_m * random_vector(&random), Eigen::Matrix3d::Zero()};
      const Vector3d along = random_vector(&random);
      cluster.mean += 0.3 * (along - normal * normal.dot(along));
      for (int i = 0; i < 20; ++i) {
        const Vector3d x = 0.4 * random_vector(&random);
        const Vector3d on_plane = x - normal * normal.dot(x) + 0.1 * error_m * normal * random.normal();
        cluster.covariance += on_plane * on_plane.transpose() / 20.0;
      }
      patch.clusters.push_back(cluster);
      patch.weights.push_back(random.uniform(0.5, 2.0));
    }
    patch.plane = fit_patch_plane(patch.clusters, patch.weights);
  }
  return patches;
}

std::vector<Vector3d> make_sensors(size_t num_scans) {
  Random random(3);
  std::vector<Vector3d> sensors;
  for (size_t i = 0; i < num_scans; ++i) sensors.push_back(random_vector(&random));
  return sensors;
}

/// The cost after the corrections, planes fitted anew.
double cost_after(std::vector<WeightedPatch> patches, const std::vector<Vector3d>& sensors,
                  const Eigen::VectorXd& corrections) {
  for (WeightedPatch& patch : patches) {
    for (ScanCluster& cluster : patch.clusters) {
      const Vector6d d = corrections.segment<6>(6 * static_cast<Eigen::Index>(cluster.scan));
      const Eigen::Matrix3d turn = so3_exp(d.head<3>());
      const Vector3d& sensor = sensors[cluster.scan];
      cluster = moved(cluster, Rigid3(turn, sensor + d.tail<3>() - turn * sensor));
    }
    patch.plane = fit_patch_plane(patch.clusters, patch.weights);
  }
  return patch_cost(patches);
}

TEST(PatchPlane, OfTwoClustersByHand) {
  // Points at z = 0 (weight 1) and z = 3 (weight 2) spread widely in x and y: mean 2, variance (4 + 2) / 3 = 2.
  Eigen::Matrix3d wide = Eigen::Vector3d(100.0, 50.0, 0.0).asDiagonal();
  const std::vector<ScanCluster> clusters = {{0, 9.0, Vector3d(0, 0, 0), wide}, {1, 9.0, Vector3d(0, 0, 3), wide}};
  const PatchPlane plane = fit_patch_plane(clusters, {1.0, 2.0});
  EXPECT_NEAR(std::abs(plane.normal.z()), 1.0, 1e-12);
  EXPECT_NEAR(plane.mean.z(), 2.0, 1e-12);
  EXPECT_NEAR(plane.smallest, 2.0, 1e-12);
  EXPECT_NEAR(plane.second, 50.0, 1e-12);
}

TEST(PoseEquations, GradientIsThatOfTheEigenvalues) {
  constexpr size_t kScans = 4;
  const std::vector<WeightedPatch> patches = make_patches(kScans, 0.05);
  const std::vector<Vector3d> sensors = make_sensors(kScans);
  PoseEquations equations(kScans);
  add_patches(patches, sensors, &equations);
  constexpr double kStep = 1e-6;
  for (Eigen::Index i = 0; i < 24; ++i) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(24, i);
    const double numeric = (cost_after(patches, sensors, step) - cost_after(patches, sensors, -step)) / (2.0 * kStep);
    const Vector6d& gradient = equations.gradients[static_cast<size_t>(i) / 6];
    EXPECT_NEAR(gradient[i % 6], numeric, 1e-6 * (1.0 + std::abs(numeric))) << i;
  }
}

TEST(PoseEquations, HessianIsThatOfTheEigenvaluesWhereThePatchesAreThin) {
  constexpr size_t kScans = 3;
  const std::vector<WeightedPatch> patches = make_patches(kScans, 1e-4);
  const std::vector<Vector3d> sensors = make_sensors(kScans);
  PoseEquations equations(kScans);
  add_patches(patches, sensors, &equations);
  const Eigen::MatrixXd hessian = equations.dense();
  constexpr double kStep = 1e-4;
  const auto cost = [&](Eigen::Index i, double si, Eigen::Index j, double sj) {
    return cost_after(patches, sensors,
                      kStep * (si * Eigen::VectorXd::Unit(18, i) + sj * Eigen::VectorXd::Unit(18, j)));
  };
  for (Eigen::Index i = 0; i < 18; ++i) {
    for (Eigen::Index j = 0; j < 18; ++j) {
      const double numeric =
          (cost(i, 1, j, 1) - cost(i, 1, j, -1) - cost(i, -1, j, 1) + cost(i, -1, j, -1)) / (4.0 * kStep * kStep);
      EXPECT_NEAR(hessian(i, j), numeric, 2e-3 * hessian.diagonal().maxCoeff()) << i << " " << j;
    }
  }
}

TEST(PoseEquations, CommonMotionCostsNothing) {
  constexpr size_t kScans = 5;
  const std::vector<Vector3d> sensors = make_sensors(kScans);
  PoseEquations equations(kScans);
  add_patches(make_patches(kScans, 0.01), sensors, &equations);
  const Eigen::MatrixXd hessian = equations.dense();
  const Vector3d turn(0.3, -0.5, 0.8);
  const Vector3d shift(1.0, 2.0, -0.5);
  Eigen::VectorXd motion(30);
  for (Eigen::Index i = 0; i < 5; ++i)
    motion.segment<6>(6 * i) << turn, turn.cross(sensors[static_cast<size_t>(i)]) + shift;
  EXPECT_LT((hessian * motion).norm(), 1e-9 * hessian.norm() * motion.norm());
}

TEST(PoseEquations, SparseAndDenseSolutionsAgree) {
  constexpr size_t kScans = 30;  // a chain: few blocks are filled
  PoseEquations equations(kScans);
  Random random(4);
  for (size_t i = 0; i < kScans; ++i) {
    const Vector6d offset = Vector6d::NullaryExpr([&] { return random.normal(); });
    equations.add_prior(i, offset, Vector6d::Constant(2.0));
    if (i > 0) equations.add_smoothness(i - 1, 0.5 * offset, Vector6d::Constant(5.0));
  }
  Eigen::VectorXd gradient(6 * kScans);
  for (size_t i = 0; i < kScans; ++i) gradient.segment<6>(6 * static_cast<Eigen::Index>(i)) = equations.gradients[i];
  EXPECT_LT((equations.dense() * equations.solve() + gradient).norm(), 1e-10 * gradient.norm());
}

TEST(PoseEquations, AreTheSameForAnyNumberOfThreads) {
  const int before = num_threads();
  std::vector<Eigen::MatrixXd> hessians;
  for (const int threads : {1, 2}) {
    set_num_threads(threads);
    PoseEquations equations(6);
    add_patches(make_patches(6, 0.02), make_sensors(6), &equations);
    hessians.push_back(equations.dense());
  }
  set_num_threads(before);
  EXPECT_EQ(hessians[0], hessians[1]);
}

}  // namespace
}  // namespace cpplus
