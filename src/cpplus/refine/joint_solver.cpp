#include "cpplus/refine/joint_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "cpplus/core/parallel.h"
#include "cpplus/refine/selected_inverse.h"
#include "cpplus/refine/surface_match_residual.h"

namespace cpplus {
namespace {

constexpr int kMaxSteps = 12;
// Scale of the patches' loss in the first round, in that of the last: poses that start tens of pixels off are drawn in by
// all their patches before outliers lose their weight (graduated non-convexity).
constexpr double kFirstPatchLoss = 16.0;
constexpr double kStudentDegrees = 4.0;
// Least size of the drift, in prior sigmas.
constexpr double kMinDrift = 0.03;

// Normal equations of one image's own evidence: its robust cost and half its derivatives by the perturbation.
struct EdgeTerm {
  Matrix6d h = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double cost = 0.0;
};

struct PairTerm {
  size_t a = 0, b = 0;
  std::vector<const SurfaceMatch*> matches;
  std::vector<double> weights;
  Matrix6d h_aa = Matrix6d::Zero();
  Matrix6d h_ab = Matrix6d::Zero();
  Matrix6d h_bb = Matrix6d::Zero();
  Vector6d g_a = Vector6d::Zero();
  Vector6d g_b = Vector6d::Zero();
  double cost = 0.0;
};

// Prior of one number a component of the correction: rotation and translation.
struct Spread {
  double rotation = 1.0;
  double translation = 1.0;
  Vector6d times(const Vector6d& sigmas) const {
    Vector6d result;
    result << rotation * sigmas.head<3>(), translation * sigmas.tail<3>();
    return result;
  }
};

double cauchy_cost(double squared, double scale) { return scale * scale * std::log1p(squared / (scale * scale)); }
double cauchy_weight(double squared, double scale) { return 1.0 / (1.0 + squared / (scale * scale)); }

class JointSolver {
 public:
  JointSolver(const JointProblem& problem, const Vector6d& prior_sigmas, const JointEdgeOptions& edges,
              const JointOptions& options)
      : problem_(problem), prior_sigmas_(prior_sigmas), edge_options_(edges), options_(options) {
    for (const JointImage& image : problem.images) poses_.push_back(image.camera_from_map);
    matches_.resize(poses_.size());
    in_sequence_.resize(poses_.size(), false);
    edge_terms_.resize(poses_.size());
    int column = static_cast<int>(6 * poses_.size());
    for (const auto& [camera, sequence] : problem.sequences) {
      shared_column_[camera] = column;
      shared_[camera] = Vector7d::Zero();
      column += 7;
      std::vector<double> gaps;
      for (size_t k = 1; k < sequence.size(); ++k) gaps.push_back(sequence[k].first - sequence[k - 1].first);
      std::sort(gaps.begin(), gaps.end());
      for (const auto& [time, i] : sequence) in_sequence_[i] = true;
      typical_gap_[camera] = gaps.empty() ? 1.0 : std::max(1e-9, gaps[gaps.size() / 2]);
    }
    size_ = column;
    group_matches();
  }

  JointResult run() {
    for (int round = 0; round < options_.rounds; ++round) {
      match_edges(radius_of(round));
      patch_loss_scale_ = edge_options_.loss_scale * std::pow(kFirstPatchLoss, 1.0 - progress_of(round));
      minimise();
      if (round + 1 < options_.rounds) learn_spread();
    }
    return result();
  }

 private:
  using Vector7d = Eigen::Matrix<double, 7, 1>;

  void group_matches() {
    std::map<std::pair<size_t, size_t>, std::vector<const SurfaceMatch*>> pairs;
    for (const SurfaceMatch& m : problem_.matches) {
      if (in_sequence_[m.image_a] && in_sequence_[m.image_b]) pairs[{m.image_a, m.image_b}].push_back(&m);
    }
    const double own = options_.patch_sigma_px * options_.patch_sigma_px;
    const double common = options_.plane_sigma_px * options_.plane_sigma_px;
    for (auto& [images, matches] : pairs) {
      PairTerm pair;
      pair.a = images.first;
      pair.b = images.second;
      std::map<int32_t, int> on_plane;
      for (const SurfaceMatch* m : matches) ++on_plane[m->plane];
      // As for the samples of an edge (match_weight.h).
      for (const SurfaceMatch* m : matches)
        pair.weights.push_back((own + common) / (own + on_plane[m->plane] * common));
      pair.matches = std::move(matches);
      pairs_.push_back(std::move(pair));
    }
  }

  double progress_of(int round) const {
    return options_.rounds > 1 ? static_cast<double>(round) / (options_.rounds - 1) : 1.0;
  }

  double radius_of(int round) const {
    return edge_options_.first_radius_px *
           std::pow(edge_options_.last_radius_px / edge_options_.first_radius_px, progress_of(round));
  }

  void match_edges(double radius_px) {
    parallel_for_each(poses_.size(), [&](size_t i) {
      const JointImage& image = problem_.images[i];
      if (image.edges == nullptr) return;
      matches_[i] = image.edges->match(*image.camera, poses_[i], radius_px, edge_options_.noise, image.edges->all());
    });
  }

  EdgeTerm own_term(size_t i, const Rigid3& pose) const {
    if (!in_sequence_[i]) return {};
    return problem_.images[i].observed ? observation_term(*problem_.images[i].observed, pose) : edge_term(i, pose);
  }

  // Student's t.
  EdgeTerm observation_term(const PoseObservation& observed, const Rigid3& pose) const {
    const Matrix6d information = observed.information / options_.covariance_inflation;
    const Vector6d difference = camera_difference(observed.camera_from_map, pose);
    const double squared = difference.dot(information * difference);
    const double weight = (kStudentDegrees + 6.0) / (kStudentDegrees + squared);
    EdgeTerm term;
    term.h = weight * information;
    term.g = term.h * difference;
    term.cost = (kStudentDegrees + 6.0) * std::log1p(squared / kStudentDegrees);
    return term;
  }

  EdgeTerm edge_term(size_t i, const Rigid3& pose) const {
    EdgeTerm term;
    for (const EdgeMatch& m : matches_[i]) {
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> d_pixel_d_x;
      const Eigen::Vector3d x = pose * m.x_in_map;
      if (!problem_.images[i].camera->project(x, &pixel, &d_pixel_d_x)) continue;
      const double r = m.normal.dot(pixel - m.pixel) / m.sigma_px;
      const Eigen::RowVector3d slope = m.normal.transpose() * d_pixel_d_x / m.sigma_px;
      Vector6d j;
      j << slope.transpose().cross(x), -slope.transpose();
      const double weight = m.weight * cauchy_weight(r * r, edge_options_.loss_scale);
      term.h.noalias() += weight * j * j.transpose();
      term.g += weight * r * j;
      term.cost += m.weight * cauchy_cost(r * r, edge_options_.loss_scale);
    }
    return term;
  }

  void evaluate(PairTerm* pair, const std::vector<Rigid3>& poses) const {
    pair->h_aa.setZero();
    pair->h_ab.setZero();
    pair->h_bb.setZero();
    pair->g_a.setZero();
    pair->g_b.setZero();
    pair->cost = 0.0;
    const double sigma = std::hypot(options_.patch_sigma_px, options_.plane_sigma_px);
    for (size_t k = 0; k < pair->matches.size(); ++k) {
      const auto r = surface_match_residual(*pair->matches[k], *problem_.images[pair->a].camera, poses[pair->a],
                                            *problem_.images[pair->b].camera, poses[pair->b]);
      if (!r) continue;
      const double squared = r->residual.squaredNorm() / (sigma * sigma);
      const double weight = pair->weights[k] * cauchy_weight(squared, patch_loss_scale_) / (sigma * sigma);
      pair->h_aa.noalias() += weight * r->by_a.transpose() * r->by_a;
      pair->h_ab.noalias() += weight * r->by_a.transpose() * r->by_b;
      pair->h_bb.noalias() += weight * r->by_b.transpose() * r->by_b;
      pair->g_a.noalias() += weight * r->by_a.transpose() * r->residual;
      pair->g_b.noalias() += weight * r->by_b.transpose() * r->residual;
      pair->cost += pair->weights[k] * cauchy_cost(squared, patch_loss_scale_);
    }
  }

  // Correction of the coarse pose that is not explained by what the images share.
  Vector6d drift(size_t i, const std::vector<Rigid3>& poses, const std::map<uint32_t, Vector7d>& shared) const {
    const JointImage& image = problem_.images[i];
    const Vector7d& s = shared.at(image.camera_id);
    return camera_difference(image.coarse_camera_from_map, poses[i]) - s.head<6>() - velocity(i) * s(6);
  }

  Vector6d velocity(size_t i) const { return problem_.images[i].velocity_per_s.value_or(Vector6d::Zero()); }

  Vector6d step_sigmas(uint32_t camera, double gap) const {
    return step_.times(prior_sigmas_) * std::sqrt(std::max(1e-3, gap / typical_gap_.at(camera)));
  }

  Vector7d shared_sigmas() const {
    Vector7d sigmas;
    sigmas << 2.0 * prior_sigmas_, options_.time_offset_sigma_s;
    return sigmas;
  }

  double prior_cost(const std::vector<Rigid3>& poses, const std::map<uint32_t, Vector7d>& shared) const {
    double cost = 0.0;
    const Vector6d drift_sigmas = drift_.times(prior_sigmas_);
    for (const auto& [camera, sequence] : problem_.sequences) {
      cost += shared.at(camera).cwiseQuotient(shared_sigmas()).squaredNorm();
      Vector6d last = Vector6d::Zero();
      for (size_t k = 0; k < sequence.size(); ++k) {
        const Vector6d d = drift(sequence[k].second, poses, shared);
        cost += d.cwiseQuotient(drift_sigmas).squaredNorm();
        if (k > 0) {
          const double gap = sequence[k].first - sequence[k - 1].first;
          cost += (d - last).cwiseQuotient(step_sigmas(camera, gap)).squaredNorm();
        }
        last = d;
      }
    }
    return cost;
  }

  double evaluate_all(const std::vector<Rigid3>& poses, const std::map<uint32_t, Vector7d>& shared) {
    parallel_for_each(poses.size(), [&](size_t i) { edge_terms_[i] = own_term(i, poses[i]); });
    parallel_for_each(pairs_.size(), [&](size_t k) { evaluate(&pairs_[k], poses); });
    double cost = prior_cost(poses, shared);
    for (const EdgeTerm& term : edge_terms_) cost += term.cost;
    for (const PairTerm& pair : pairs_) cost += pair.cost;
    return cost;
  }

  // Lower triangle only.
  template <typename Block>
  void add_block(int row, int column, const Block& block) {
    for (int c = 0; c < block.cols(); ++c) {
      for (int r = 0; r < block.rows(); ++r) {
        if (row + r >= column + c) triplets_.emplace_back(row + r, column + c, block(r, c));
      }
    }
  }

  // A prior on A x where x are the columns of some blocks: residual r, diagonal information w.
  struct LinearBlock {
    int column;
    Eigen::Matrix<double, 6, Eigen::Dynamic> design;
  };
  void add_prior(const std::vector<LinearBlock>& blocks, const Vector6d& residual, const Vector6d& sigmas) {
    const Vector6d w = sigmas.cwiseAbs2().cwiseInverse();
    for (const LinearBlock& x : blocks) {
      gradient_.segment(x.column, x.design.cols()) += x.design.transpose() * w.cwiseProduct(residual);
      for (const LinearBlock& y : blocks) {
        if (x.column >= y.column) {
          add_block(x.column, y.column, Eigen::MatrixXd(x.design.transpose() * w.asDiagonal() * y.design));
        }
      }
    }
  }

  Eigen::Matrix<double, 6, 7> shared_design(size_t i) const {
    Eigen::Matrix<double, 6, 7> design;
    design << -Matrix6d::Identity(), -velocity(i);
    return design;
  }

  void assemble() {
    triplets_.clear();
    gradient_ = Eigen::VectorXd::Zero(size_);
    for (size_t i = 0; i < poses_.size(); ++i) {
      const int column = static_cast<int>(6 * i);
      if (!in_sequence_[i]) add_block(column, column, Matrix6d(Matrix6d::Identity()));
      add_block(column, column, edge_terms_[i].h);
      gradient_.segment<6>(column) += edge_terms_[i].g;
    }
    for (const PairTerm& pair : pairs_) {
      const int a = static_cast<int>(6 * pair.a);
      const int b = static_cast<int>(6 * pair.b);
      add_block(a, a, pair.h_aa);
      add_block(b, b, pair.h_bb);
      if (a > b)
        add_block(a, b, pair.h_ab);
      else
        add_block(b, a, Matrix6d(pair.h_ab.transpose()));
      gradient_.segment<6>(a) += pair.g_a;
      gradient_.segment<6>(b) += pair.g_b;
    }
    for (const auto& [camera, sequence] : problem_.sequences) assemble_sequence(camera, sequence);
    information_.resize(size_, size_);
    information_.setFromTriplets(triplets_.begin(), triplets_.end());
  }

  void assemble_sequence(uint32_t camera, const std::vector<std::pair<double, size_t>>& sequence) {
    const int shared_column = shared_column_.at(camera);
    const Vector7d w = shared_sigmas().cwiseAbs2().cwiseInverse();
    add_block(shared_column, shared_column, Eigen::Matrix<double, 7, 7>(w.asDiagonal()));
    gradient_.segment<7>(shared_column) += w.cwiseProduct(shared_.at(camera));
    const Vector6d drift_sigmas = drift_.times(prior_sigmas_);
    for (size_t k = 0; k < sequence.size(); ++k) {
      const size_t i = sequence[k].second;
      const int column = static_cast<int>(6 * i);
      const Vector6d d = drift(i, poses_, shared_);
      add_prior({{column, Matrix6d::Identity()}, {shared_column, shared_design(i)}}, d, drift_sigmas);
      if (k == 0) continue;
      const size_t before = sequence[k - 1].second;
      const double gap = sequence[k].first - sequence[k - 1].first;
      add_prior({{column, Matrix6d::Identity()},
                 {static_cast<int>(6 * before), -Matrix6d::Identity()},
                 {shared_column, shared_design(i) - shared_design(before)}},
                d - drift(before, poses_, shared_), step_sigmas(camera, gap));
    }
  }

  // Levenberg-Marquardt with weights of the robust loss fixed in each step.
  void minimise() {
    double cost = evaluate_all(poses_, shared_);
    double damping = 1e-6;
    for (int step = 0; step < kMaxSteps; ++step) {
      assemble();
      Eigen::SparseMatrix<double> damped = information_;
      for (int i = 0; i < size_; ++i) damped.coeffRef(i, i) *= 1.0 + damping;
      factor_.compute(damped);
      const Eigen::VectorXd x = -factor_.solve(gradient_);
      std::vector<Rigid3> poses = poses_;
      std::map<uint32_t, Vector7d> shared = shared_;
      for (size_t i = 0; i < poses.size(); ++i) {
        poses[i] = perturb_camera(poses[i], x.segment<6>(static_cast<Eigen::Index>(6 * i)));
      }
      for (auto& [camera, value] : shared) value += x.segment<7>(shared_column_.at(camera));
      const double new_cost = evaluate_all(poses, shared);
      if (!(new_cost < cost)) {
        damping = std::max(1e-4, 10.0 * damping);
        cost = evaluate_all(poses_, shared_);
        if (damping > 1e4) break;
        continue;
      }
      const bool converged = cost - new_cost < 1e-4 * (1.0 + cost) * 1e-2;
      poses_ = std::move(poses);
      shared_ = std::move(shared);
      cost = new_cost;
      damping = std::max(1e-9, 0.1 * damping);
      if (converged) break;
    }
  }

  void factorise() {
    evaluate_all(poses_, shared_);
    assemble();
    factor_.compute(information_);
  }

  Matrix6d covariance_block(const SelectedInverse& inverse, size_t i, size_t j) const {
    Matrix6d block;
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c < 6; ++c) {
        block(r, c) = inverse.at(static_cast<Eigen::Index>(6 * i) + r, static_cast<Eigen::Index>(6 * j) + c);
      }
    }
    return block;
  }

  // Expected squares of drift and of its steps given the data, in prior sigmas (the uncertainty of what the images
  // share is left out of the former: it is small beside the drift where there is any).
  void learn_spread() {
    factorise();
    const SelectedInverse inverse(factor_);
    Spread drift_squares{0, 0}, step_squares{0, 0};
    int drifts = 0, steps = 0;
    const auto add = [&](const Vector6d& d, const Matrix6d& covariance, double scale, Spread* sum) {
      const Vector6d squares = (d.cwiseAbs2() + covariance.diagonal()).cwiseQuotient(prior_sigmas_.cwiseAbs2()) / scale;
      sum->rotation += squares.head<3>().mean();
      sum->translation += squares.tail<3>().mean();
    };
    for (const auto& [camera, sequence] : problem_.sequences) {
      for (size_t k = 0; k < sequence.size(); ++k) {
        const size_t i = sequence[k].second;
        const Vector6d d = drift(i, poses_, shared_);
        const Matrix6d own = covariance_block(inverse, i, i);
        add(d, own, 1.0, &drift_squares);
        ++drifts;
        if (k == 0) continue;
        const size_t before = sequence[k - 1].second;
        const Matrix6d cross = covariance_block(inverse, i, before);
        const double gap = std::max(1e-3, (sequence[k].first - sequence[k - 1].first) / typical_gap_.at(camera));
        add(d - drift(before, poses_, shared_),
            own + covariance_block(inverse, before, before) - cross - cross.transpose(), gap, &step_squares);
        ++steps;
      }
    }
    const auto root = [](const Spread& sum, int count) {
      return Spread{std::clamp(std::sqrt(sum.rotation / std::max(1, count)), kMinDrift, 2.0),
                    std::clamp(std::sqrt(sum.translation / std::max(1, count)), kMinDrift, 2.0)};
    };
    drift_ = root(drift_squares, drifts);
    step_ = root(step_squares, steps);
  }

  JointResult result() {
    factorise();
    const SelectedInverse inverse(factor_);
    JointResult result;
    for (size_t i = 0; i < poses_.size(); ++i) {
      JointPose pose;
      pose.camera_from_map = poses_[i];
      pose.covariance = covariance_block(inverse, i, i);
      // At the minimum all gradients add up to zero: that of everything else is minus that of the image's own edges.
      const Matrix6d rest = pose.covariance.inverse() - edge_terms_[i].h;
      const Eigen::LDLT<Matrix6d> ldlt(rest);
      pose.from_others = {perturb_camera(poses_[i], ldlt.solve(edge_terms_[i].g)),
                          Matrix6d(ldlt.solve(Matrix6d::Identity()))};
      result.poses.push_back(pose);
    }
    for (const auto& [camera, value] : shared_) {
      SharedErrors errors;
      const int column = shared_column_.at(camera);
      errors.num_images = static_cast<int>(problem_.sequences.at(camera).size());
      errors.extrinsic = value.head<6>();
      for (int k = 0; k < 6; ++k) errors.extrinsic_sigmas(k) = std::sqrt(inverse.at(column + k, column + k));
      errors.time_offset_s = value(6);
      errors.time_offset_sigma_s = std::sqrt(inverse.at(column + 6, column + 6));
      result.shared[camera] = errors;
    }
    return result;
  }

  const JointProblem& problem_;
  const Vector6d prior_sigmas_;
  const JointEdgeOptions& edge_options_;
  const JointOptions& options_;
  std::vector<Rigid3> poses_;
  std::map<uint32_t, Vector7d> shared_;  // extrinsic error, time offset
  std::map<uint32_t, int> shared_column_;
  std::map<uint32_t, double> typical_gap_;
  int size_ = 0;
  std::vector<char> in_sequence_;  // others have no part; their columns are held by ones on the diagonal
  std::vector<std::vector<EdgeMatch>> matches_;
  std::vector<EdgeTerm> edge_terms_;
  std::vector<PairTerm> pairs_;
  double patch_loss_scale_ = 1.0;
  Spread drift_, step_;
  std::vector<Eigen::Triplet<double>> triplets_;
  Eigen::VectorXd gradient_;
  Eigen::SparseMatrix<double> information_;
  SelectedInverse::Factor factor_;
};

}  // namespace

void JointOptions::validate() const {
  check_option(rounds >= 1, "rounds", "[1, inf)", rounds);
  check_option(patch_sigma_px > 0, "patch_sigma_px", "(0, inf)", patch_sigma_px);
  check_option(plane_sigma_px > 0, "plane_sigma_px", "(0, inf)", plane_sigma_px);
  check_option(time_offset_sigma_s > 0, "time_offset_sigma_s", "(0, inf)", time_offset_sigma_s);
  check_option(covariance_inflation >= 1, "covariance_inflation", "[1, inf)", covariance_inflation);
}

JointResult solve_joint(const JointProblem& problem, const Vector6d& prior_sigmas, const JointEdgeOptions& edges,
                        const JointOptions& options) {
  return JointSolver(problem, prior_sigmas, edges, options).run();
}

}  // namespace cpplus
