#include "cpplus/refine/unproven_directions.h"

#include <gtest/gtest.h>

#include "cpplus/refine/pose_search.h"

namespace cpplus {
namespace {

const Vector6d kPrior = PosePrior().sigmas();

// Information in that of the prior, one number a component.
Matrix6d information_of(const Vector6d& in_priors) { return in_priors.cwiseQuotient(kPrior.cwiseAbs2()).asDiagonal(); }

Vector6d well_known_but(int component, double information) {
  Vector6d in_priors = Vector6d::Constant(1000.0);
  in_priors(component) = information;
  return in_priors;
}

// Likelihood that falls by `slope` a prior's deviation along a component.
auto falling_along(int component, double slope) {
  return [=](const Vector6d& delta) { return 50.0 - slope * std::abs(delta(component)) / kPrior(component); };
}

TEST(UnprovenDirections, AFlatLikelihoodProvesNothing) {
  const PoseDirections found =
      unproven_directions(information_of(well_known_but(5, 6.0)), kPrior, 10.0, falling_along(5, 2.0));
  ASSERT_EQ(found.cols(), 1);
  EXPECT_NEAR(std::abs(found(5, 0)), kPrior(5), 1e-12);
  EXPECT_NEAR(found.col(0).head<5>().norm(), 0.0, 1e-12);
}

TEST(UnprovenDirections, ALikelihoodThatFallsOnBothSidesProvesIt) {
  const Matrix6d information = information_of(well_known_but(5, 6.0));
  EXPECT_EQ(unproven_directions(information, kPrior, 10.0, falling_along(5, 5.1)).cols(), 0);
  // On one side alone: the pose may lie farther on the other.
  const auto one_side = [](const Vector6d& delta) { return 30.0 * delta(5) / kPrior(5); };
  EXPECT_EQ(unproven_directions(information, kPrior, 10.0, one_side).cols(), 1);
}

TEST(UnprovenDirections, WhatIsKnownWellIsNotAsked) {
  const auto never = [](const Vector6d&) -> double { throw std::logic_error("asked"); };
  EXPECT_EQ(unproven_directions(information_of(Vector6d::Constant(20.0)), kPrior, 10.0, never).cols(), 0);
}

EvidenceTerm term_of(const Matrix6d& information, const Vector6d& gradient) {
  EvidenceTerm term;
  term.h = information;
  term.g = gradient;
  term.cost = 40.0;
  return term;
}

TEST(FreeDirections, NothingIsKnownAlongThem) {
  const Matrix6d information = information_of(well_known_but(5, 6.0));
  EvidenceTerm term = term_of(information, Vector6d::Constant(100.0));
  PoseDirections axis(6, 1);
  axis.col(0) = kPrior(5) * Vector6d::Unit(5);
  free_directions(axis, kPrior, &term);
  EXPECT_NEAR((term.h * axis).norm(), 0.0, 1e-6);
  EXPECT_NEAR(axis.col(0).dot(term.g), 0.0, 1e-7);
  // The others as well as the map's error of 5 mm and 0.05 degrees allows, with information and error adding up.
  const double error_m = 0.005;
  EXPECT_NEAR(term.h(3, 3), 1.0 / (1.0 / information(3, 3) + error_m * error_m), 1e-6 * information(3, 3));
  const double error_rad = 0.05 * std::numbers::pi / 180.0;
  EXPECT_NEAR(term.h(0, 0), 1.0 / (1.0 / information(0, 0) + error_rad * error_rad), 1e-6 * information(0, 0));
  EXPECT_LT(term.cost, 40.0);
}

TEST(FreeDirections, OneThatHasTurnedALittleTakesNothingElseAlong) {
  const Matrix6d information = information_of(well_known_but(5, 0.0));
  PoseDirections askew(6, 1);
  askew.col(0) = kPrior(5) * (0.02 * Vector6d::Unit(3) + Vector6d::Unit(5)).normalized();
  EvidenceTerm term = term_of(information, Vector6d::Zero());
  free_directions(askew, kPrior, &term);
  EXPECT_NEAR(term.h(3, 3), 1.0 / (1.0 / information(3, 3) + 0.005 * 0.005), 1e-6 * information(3, 3));
}

TEST(FreeDirections, WithoutDirectionsNothingChanges) {
  const Matrix6d information = information_of(Vector6d::Constant(3.0));
  EvidenceTerm term = term_of(information, Vector6d::Ones());
  free_directions(PoseDirections(6, 0), kPrior, &term);
  EXPECT_EQ(term.h, information);
  EXPECT_EQ(term.g, Vector6d::Ones());
  EXPECT_EQ(term.cost, 40.0);
}

}  // namespace
}  // namespace cpplus
