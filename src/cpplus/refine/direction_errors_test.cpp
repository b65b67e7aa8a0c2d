#include "cpplus/refine/direction_errors.h"

#include <gtest/gtest.h>

#include "cpplus/core/random.h"
#include "cpplus/refine/edge_match.h"

namespace cpplus {
namespace {

constexpr double kFocalPx = 500.0;
constexpr double kDirectionSigma = 0.01;  // rad

// A point at x_in_camera (the map's frame is the camera's) on an edge along `direction`, whose normal in the image and
// in space is `normal`, as a pinhole camera sees it.
EdgeMatch match_at(const Eigen::Vector3d& x_in_camera, const Eigen::Vector3d& direction,
                   const Eigen::Vector2d& normal) {
  EdgeMatch m;
  m.x_in_map = x_in_camera;
  m.normal = normal;
  const double z = x_in_camera.z();
  Eigen::Matrix<double, 2, 3> d_pixel_d_x;
  d_pixel_d_x << kFocalPx / z, 0, -kFocalPx * x_in_camera.x() / (z * z),  //
      0, kFocalPx / z, -kFocalPx * x_in_camera.y() / (z * z);
  m.projected.d_pixel_d_delta = d_pixel_d_x * d_camera_point_d_delta(x_in_camera);
  m.slip_in_map = kDirectionSigma * (normal.transpose() * d_pixel_d_x).norm() * direction;
  return m;
}

// Edges along the camera's axis all round it, their directions wrong by kDirectionSigma at random.
std::vector<EdgeMatch> corridor(uint64_t seed) {
  Random random(seed);
  std::vector<EdgeMatch> matches;
  for (int k = 0; k < 200; ++k) {
    const double angle = 0.1 * k;
    const Eigen::Vector2d outward(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d across(-outward.y(), outward.x());
    const double z = random.uniform(2.0, 6.0);
    // The line runs off its true direction sideways: its image is turned.
    const double error = kDirectionSigma * random.normal();
    const Eigen::Vector2d normal = (across - error * z * outward).normalized();
    matches.push_back(match_at({outward.x(), outward.y(), z}, Eigen::Vector3d::UnitZ(), normal));
  }
  return matches;
}

double along_axis(const Matrix6d& information) { return 1.0 / information.inverse()(5, 5); }

TEST(DirectionErrors, WhatTheyFeignAlongACorridorIsNoInformation) {
  std::vector<EdgeMatch> matches = corridor(1);
  const Matrix6d discounted = edge_information(matches, 1.5);
  for (EdgeMatch& m : matches) m.slip_in_map.setZero();
  const Matrix6d believed = edge_information(matches, 1.5);
  EXPECT_GT(along_axis(believed), 100.0);  // a decimetre, of a place that nothing tells
  EXPECT_LT(discounted(5, 5), 1e-6 * believed(0, 0));
  // Across the axis and in rotation nothing is lost.
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(discounted(i, i), believed(i, i), 0.01 * believed(i, i)) << i;
}

TEST(DirectionErrors, OneEdgeAcrossTheCorridorCounts) {
  std::vector<EdgeMatch> matches = corridor(2);
  for (const double x : {-0.5, 0.0, 0.5}) {
    matches.push_back(match_at({x, -1.0, 3.0}, Eigen::Vector3d::UnitX(), Eigen::Vector2d::UnitY()));
    matches.push_back(match_at({x, 1.0, 3.0}, Eigen::Vector3d::UnitX(), Eigen::Vector2d::UnitY()));
  }
  // Six samples that a metre along the axis moves by 500 * 1 / 9 px each.
  const double of_edges = 6.0 * std::pow(500.0 / 9.0, 2);
  EXPECT_GT(along_axis(edge_information(matches, 1.5)), 0.5 * of_edges);
}

TEST(DirectionErrors, TheCostIsThatOfTheBestPlaceAlongWhatIsNotKnown) {
  // Pose (a, 0, 0, 0, 0, b): a is known, b is feigned.
  DirectionErrors errors;
  EdgeMatch m;
  m.slip_in_map = Eigen::Vector3d(0, 0, 1);
  errors.add(m, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity(), 9.0);
  Eigen::MatrixXd h = Eigen::MatrixXd::Identity(7, 7) * 100.0;
  h(5, 5) = 18.0;  // twice what the errors feign
  h(5, 6) = h(6, 5) = 3.0;
  Eigen::VectorXd g = Eigen::VectorXd::Ones(7);
  double cost = 5.0;
  errors.discount(&h, &g, &cost);
  EXPECT_NEAR(h(0, 0), 100.0, 1e-9);
  EXPECT_NEAR(h(5, 5), 0.0, 1e-9);
  EXPECT_NEAR(h(5, 6), 0.0, 1e-9);
  EXPECT_NEAR(h(6, 6), 100.0, 1e-9);
  EXPECT_NEAR(g(0), 1.0, 1e-9);
  EXPECT_NEAR(g(5), 0.0, 1e-9);
  EXPECT_NEAR(cost, 5.0 - 1.0 / 18.0, 1e-9);
}

TEST(DirectionErrors, WithoutMatchesNothingChanges) {
  EXPECT_EQ(DirectionErrors().discounted(Matrix6d::Identity()), Matrix6d::Identity());
  EXPECT_EQ(DirectionErrors().discounted(Matrix6d::Zero()), Matrix6d::Zero());
}

}  // namespace
}  // namespace cpplus
