#include "cpplus/refine/pose_sequence.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cpplus {
namespace {

constexpr double kStudentDegrees = 4.0;
constexpr int kRobustRounds = 4;

// A Gaussian in information form: information = inverse covariance, vector = information * mean.
struct Gaussian {
  Matrix6d information = Matrix6d::Zero();
  Vector6d vector = Vector6d::Zero();

  Gaussian operator+(const Gaussian& other) const { return {information + other.information, vector + other.vector}; }
  Matrix6d covariance() const { return information.llt().solve(Matrix6d::Identity()); }
  Vector6d mean() const { return information.llt().solve(vector); }
};

// After a step of the random walk with covariance diag(step_variances); holds for singular information too.
Gaussian diffuse(const Gaussian& state, const Vector6d& step_variances) {
  const Matrix6d spread = Matrix6d::Identity() + state.information * step_variances.asDiagonal();
  const Eigen::PartialPivLU<Matrix6d> lu(spread);
  Gaussian result;
  result.information = lu.solve(state.information);
  result.information = 0.5 * (result.information + result.information.transpose().eval());
  result.vector = lu.solve(state.vector);
  return result;
}

class SequenceSmoother {
 public:
  SequenceSmoother(const std::vector<PoseCorrection>& corrections, const Vector6d& prior_sigmas,
                   const PoseSequenceOptions& options)
      : corrections_(corrections), prior_sigmas_(prior_sigmas), options_(options), weights_(corrections.size(), 1.0) {
    prior_.information = (2.0 * prior_sigmas).cwiseAbs2().cwiseInverse().asDiagonal();
    std::vector<double> gaps;
    for (size_t i = 1; i < corrections.size(); ++i) gaps.push_back(corrections[i].time - corrections[i - 1].time);
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
    typical_gap_ = std::max(1e-9, gaps[gaps.size() / 2]);
  }

  std::vector<PosePrediction> run() {
    double best = -std::numeric_limits<double>::infinity();
    double best_step = 1.0;
    for (const double step : {0.05, 0.1, 0.2, 0.4, 0.8, 1.6}) {
      step_ = step;
      std::fill(weights_.begin(), weights_.end(), 1.0);
      for (int round = 0; round < kRobustRounds; ++round) reweigh(cavities());
      const double likelihood = log_likelihood(cavities());
      if (likelihood <= best) continue;
      best = likelihood;
      best_step = step;
    }
    step_ = best_step;
    std::fill(weights_.begin(), weights_.end(), 1.0);
    for (int round = 0; round < kRobustRounds; ++round) reweigh(cavities());
    return predictions(cavities());
  }

 private:
  Vector6d step_variances(size_t i) const {
    const double gap = (corrections_[i + 1].time - corrections_[i].time) / typical_gap_;
    return (step_ * prior_sigmas_).cwiseAbs2() * std::max(gap, 1e-3);
  }

  Gaussian observation(size_t i) const {
    if (!corrections_[i].usable) return {};
    const Matrix6d information = weights_[i] / options_.covariance_inflation * corrections_[i].information;
    return {information, information * corrections_[i].correction};
  }

  // For each image, what all the others say of it.
  std::vector<Gaussian> cavities() const {
    const size_t n = corrections_.size();
    std::vector<Gaussian> cavity(n);
    Gaussian forward = prior_;
    for (size_t i = 0; i < n; ++i) {
      cavity[i] = forward;
      if (i + 1 < n) forward = diffuse(forward + observation(i), step_variances(i));
    }
    Gaussian backward;
    for (size_t i = n; i-- > 0;) {
      cavity[i] = cavity[i] + backward;
      if (i > 0) backward = diffuse(backward + observation(i), step_variances(i - 1));
    }
    return cavity;
  }

  // Covariance of the image's own correction as far as it is told from the prior.
  Matrix6d own_covariance(size_t i) const {
    Gaussian own{corrections_[i].information / options_.covariance_inflation, Vector6d::Zero()};
    own.information += Matrix6d(prior_sigmas_.cwiseAbs2().cwiseInverse().asDiagonal());
    return own.covariance();
  }

  double squared_distance(size_t i, const Gaussian& cavity, Matrix6d* innovation) const {
    *innovation = own_covariance(i) + cavity.covariance();
    const Vector6d difference = corrections_[i].correction - cavity.mean();
    return difference.dot(innovation->llt().solve(difference));
  }

  void reweigh(const std::vector<Gaussian>& cavity) {
    Matrix6d innovation;
    for (size_t i = 0; i < corrections_.size(); ++i) {
      if (!corrections_[i].usable) continue;
      weights_[i] =
          std::min(1.0, (kStudentDegrees + 6.0) / (kStudentDegrees + squared_distance(i, cavity[i], &innovation)));
    }
  }

  // Leave-one-out, Student's t.
  double log_likelihood(const std::vector<Gaussian>& cavity) const {
    double sum = 0.0;
    Matrix6d innovation;
    for (size_t i = 0; i < corrections_.size(); ++i) {
      if (!corrections_[i].usable) continue;
      const double squared = squared_distance(i, cavity[i], &innovation);
      const Eigen::LLT<Matrix6d> llt(innovation);
      const double log_determinant = 2.0 * llt.matrixLLT().diagonal().array().log().sum();
      sum -= 0.5 * log_determinant + 0.5 * (kStudentDegrees + 6.0) * std::log1p(squared / kStudentDegrees);
    }
    return sum;
  }

  std::vector<PosePrediction> predictions(const std::vector<Gaussian>& cavity) const {
    Vector6d floor;
    floor << Eigen::Vector3d::Constant(options_.min_rotation_sigma_deg * std::numbers::pi / 180.0),
        Eigen::Vector3d::Constant(options_.min_translation_sigma_m);
    std::vector<PosePrediction> result(cavity.size());
    Matrix6d innovation;
    for (size_t i = 0; i < cavity.size(); ++i) {
      result[i].mean = cavity[i].mean();
      result[i].sigmas = cavity[i].covariance().diagonal().cwiseSqrt().cwiseMax(floor);
      if (corrections_[i].usable) result[i].consistency = squared_distance(i, cavity[i], &innovation);
    }
    return result;
  }

  const std::vector<PoseCorrection>& corrections_;
  const Vector6d prior_sigmas_;
  const PoseSequenceOptions& options_;
  std::vector<double> weights_;
  Gaussian prior_;
  double typical_gap_ = 1.0;
  double step_ = 1.0;  // of the random walk between images a typical gap apart, in prior sigmas
};

}  // namespace

void PoseSequenceOptions::validate() const {
  check_option(covariance_inflation >= 1, "covariance_inflation", "[1, inf)", covariance_inflation);
  check_option(min_rotation_sigma_deg > 0, "min_rotation_sigma_deg", "(0, inf)", min_rotation_sigma_deg);
  check_option(min_translation_sigma_m > 0, "min_translation_sigma_m", "(0, inf)", min_translation_sigma_m);
  check_option(min_images >= 3, "min_images", "[3, inf)", min_images);
}

std::vector<PosePrediction> predict_corrections(const std::vector<PoseCorrection>& corrections,
                                                const Vector6d& prior_sigmas, const PoseSequenceOptions& options) {
  const auto usable =
      std::count_if(corrections.begin(), corrections.end(), [](const PoseCorrection& c) { return c.usable; });
  if (usable < options.min_images) return {};
  return SequenceSmoother(corrections, prior_sigmas, options).run();
}

}  // namespace cpplus
