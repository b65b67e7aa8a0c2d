#include "cpplus/refine/joint_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "cpplus/core/parallel.h"
#include "cpplus/refine/drift_model.h"
#include "cpplus/refine/selected_inverse.h"
#include "cpplus/refine/surface_match_residual.h"

namespace cpplus {
namespace {

constexpr int kMaxSteps = 12;
// Scale of the patches' loss in the first round, in that of the last: poses that start tens of pixels off are drawn in
// by all their patches before outliers lose their weight (graduated non-convexity).
constexpr double kFirstPatchLoss = 16.0;
constexpr double kStudentDegrees = 4.0;
// Least and largest size of the drift, in prior sigmas.
constexpr double kMinDrift = 0.03;
constexpr double kMaxDrift = 2.0;
constexpr int kLearningSteps = 3;  // a round

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

// Drift of a camera in prior sigmas; gaps in units of the camera's typical one.
struct Drift {
  DriftProcess rotation;
  DriftProcess translation;

  Vector6d correlations(double gap) const { return both(rotation.correlation(gap), translation.correlation(gap)); }
  Vector6d sigmas() const { return both(rotation.sigma, translation.sigma); }
  Vector6d innovation_sigmas(double gap) const {
    return both(rotation.innovation_sigma(gap), translation.innovation_sigma(gap));
  }
  static Vector6d both(double rotation, double translation) {
    Vector6d result;
    result << Eigen::Vector3d::Constant(rotation), Eigen::Vector3d::Constant(translation);
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
      // Expectation maximisation is slow where the data say little of the drift.
      for (int k = 0; k < kLearningSteps && round + 1 < options_.rounds; ++k) {
        learn_drift();
        if (k + 1 < kLearningSteps) minimise();
      }
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
      // As for the samples of an edge (match_weight.h). Tangent planes have nothing in common.
      for (const SurfaceMatch* m : matches) {
        const int count = m->plane < 0 ? 1 : on_plane[m->plane];
        pair.weights.push_back((own + common) / (own + count * common));
      }
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

  // Gaussian up to the expected square of 6 numbers, beyond it Student's t: that alone would be 2.5 times as sharp at
  // its top.
  EdgeTerm observation_term(const PoseObservation& observed, const Rigid3& pose) const {
    const Matrix6d information = observed.information / options_.covariance_inflation;
    const Vector6d difference = camera_difference(observed.camera_from_map, pose);
    const double squared = difference.dot(information * difference);
    const double beyond = std::max(0.0, squared - 6.0) / (kStudentDegrees + 6.0);
    EdgeTerm term;
    term.h = information / (1.0 + beyond);
    term.g = term.h * difference;
    term.cost = std::min(squared, 6.0) + (kStudentDegrees + 6.0) * std::log1p(beyond);
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
    const double variance = std::pow(options_.patch_sigma_px, 2) + std::pow(options_.plane_sigma_px, 2);
    for (size_t k = 0; k < pair->matches.size(); ++k) {
      const SurfaceMatch& match = *pair->matches[k];
      const auto r = surface_match_residual(match, *problem_.images[pair->a].camera, poses[pair->a],
                                            *problem_.images[pair->b].camera, poses[pair->b]);
      if (!r) continue;
      const Eigen::Vector2d by_range = match.range_sigma_m * r->by_range;
      const Eigen::Matrix2d information =
          (variance * Eigen::Matrix2d::Identity() + by_range * by_range.transpose()).inverse();
      const double squared = r->residual.dot(information * r->residual);
      const Eigen::Matrix2d w = pair->weights[k] * cauchy_weight(squared, patch_loss_scale_) * information;
      pair->h_aa.noalias() += r->by_a.transpose() * w * r->by_a;
      pair->h_ab.noalias() += r->by_a.transpose() * w * r->by_b;
      pair->h_bb.noalias() += r->by_b.transpose() * w * r->by_b;
      pair->g_a.noalias() += r->by_a.transpose() * (w * r->residual);
      pair->g_b.noalias() += r->by_b.transpose() * (w * r->residual);
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

  // Between image k of a sequence and the one before, in typical gaps.
  double gap_before(uint32_t camera, const std::vector<std::pair<double, size_t>>& sequence, size_t k) const {
    return std::max(1e-3, (sequence[k].first - sequence[k - 1].first) / typical_gap_.at(camera));
  }

  Vector7d shared_sigmas() const {
    Vector7d sigmas;
    sigmas << 2.0 * prior_sigmas_, options_.time_offset_sigma_s;
    return sigmas;
  }

  double prior_cost(const std::vector<Rigid3>& poses, const std::map<uint32_t, Vector7d>& shared) const {
    double cost = 0.0;
    for (const auto& [camera, sequence] : problem_.sequences) {
      cost += shared.at(camera).cwiseQuotient(shared_sigmas()).squaredNorm();
      Vector6d last = Vector6d::Zero();
      for (size_t k = 0; k < sequence.size(); ++k) {
        const Vector6d d = drift(sequence[k].second, poses, shared).cwiseQuotient(prior_sigmas_);
        if (k == 0) {
          cost += d.cwiseQuotient(drift_.sigmas()).squaredNorm();
        } else {
          const double gap = gap_before(camera, sequence, k);
          const Vector6d innovation = d - drift_.correlations(gap).cwiseProduct(last);
          cost += innovation.cwiseQuotient(drift_.innovation_sigmas(gap)).squaredNorm();
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
    for (size_t k = 0; k < sequence.size(); ++k) {
      const size_t i = sequence[k].second;
      const int column = static_cast<int>(6 * i);
      const Vector6d d = drift(i, poses_, shared_);
      if (k == 0) {
        add_prior({{column, Matrix6d::Identity()}, {shared_column, shared_design(i)}}, d,
                  drift_.sigmas().cwiseProduct(prior_sigmas_));
        continue;
      }
      const size_t before = sequence[k - 1].second;
      const double gap = gap_before(camera, sequence, k);
      const Matrix6d memory = drift_.correlations(gap).asDiagonal();
      add_prior({{column, Matrix6d::Identity()},
                 {static_cast<int>(6 * before), -memory},
                 {shared_column, shared_design(i) - memory * shared_design(before)}},
                d - memory * drift(before, poses_, shared_), drift_.innovation_sigmas(gap).cwiseProduct(prior_sigmas_));
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
      factorise(damped);
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

  // The matrix has the same entries each time, so that they are put in order once.
  void factorise(const Eigen::SparseMatrix<double>& matrix) {
    if (factor_.rows() == 0) factor_.analyzePattern(matrix);
    factor_.factorize(matrix);
  }

  void factorise() {
    evaluate_all(poses_, shared_);
    assemble();
    factorise(information_);
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

  // Covariances of the drifts of two images that are neighbours or the same, component by component.
  Vector6d drift_covariance(const SelectedInverse& inverse, uint32_t camera, size_t i, size_t j) const {
    const Eigen::Index s = shared_column_.at(camera);
    const Eigen::Index a = static_cast<Eigen::Index>(6 * i);
    const Eigen::Index b = static_cast<Eigen::Index>(6 * j);
    const Vector6d v = velocity(i);
    const Vector6d w = velocity(j);
    Vector6d covariance;
    for (Eigen::Index r = 0; r < 6; ++r) {
      covariance(r) = inverse.at(a + r, b + r) - inverse.at(a + r, s + r) - inverse.at(b + r, s + r) +
                      inverse.at(s + r, s + r) + (v(r) + w(r)) * inverse.at(s + r, s + 6) -
                      w(r) * inverse.at(a + r, s + 6) - v(r) * inverse.at(b + r, s + 6) +
                      v(r) * w(r) * inverse.at(s + 6, s + 6);
    }
    return covariance;
  }

  // Size and memory of the drift from its expected products given the data; the three axes have them in common.
  void learn_drift() {
    factorise();
    const SelectedInverse inverse(factor_);
    std::vector<double> first[2];
    std::vector<DriftPair> pairs[2];
    for (const auto& [camera, sequence] : problem_.sequences) {
      const Vector6d scale = prior_sigmas_.cwiseAbs2();
      Vector6d d_before = Vector6d::Zero();
      Vector6d squares_before = Vector6d::Zero();
      for (size_t k = 0; k < sequence.size(); ++k) {
        const size_t i = sequence[k].second;
        const Vector6d d = drift(i, poses_, shared_);
        const Vector6d squares = (d.cwiseAbs2() + drift_covariance(inverse, camera, i, i)).cwiseQuotient(scale);
        if (k > 0) {
          const Vector6d products =
              (d.cwiseProduct(d_before) + drift_covariance(inverse, camera, i, sequence[k - 1].second))
                  .cwiseQuotient(scale);
          const double gap = gap_before(camera, sequence, k);
          for (int part = 0; part < 2; ++part) {
            pairs[part].push_back({gap, squares_before.segment<3>(3 * part).mean(),
                                   products.segment<3>(3 * part).mean(), squares.segment<3>(3 * part).mean()});
          }
        } else {
          for (int part = 0; part < 2; ++part) first[part].push_back(squares.segment<3>(3 * part).mean());
        }
        d_before = d;
        squares_before = squares;
      }
    }
    drift_.rotation = most_likely_drift(first[0], pairs[0], kMinDrift, kMaxDrift);
    drift_.translation = most_likely_drift(first[1], pairs[1], kMinDrift, kMaxDrift);
  }

  // At the minimum all gradients add up to zero: that of everything else is minus that of the image's own edges.
  std::vector<PoseGuess> guesses_from_others() {
    factorise();
    const SelectedInverse inverse(factor_);
    std::vector<PoseGuess> guesses;
    for (size_t i = 0; i < poses_.size(); ++i) {
      const Matrix6d rest = covariance_block(inverse, i, i).inverse() - edge_terms_[i].h;
      const Eigen::LDLT<Matrix6d> ldlt(rest);
      guesses.emplace_back(perturb_camera(poses_[i], ldlt.solve(edge_terms_[i].g)),
                           Matrix6d(ldlt.solve(Matrix6d::Identity())));
    }
    return guesses;
  }

  // Divides the information of edges and patches (that of observations is so already).
  void inflate_evidence() {
    for (size_t i = 0; i < poses_.size(); ++i) {
      if (!problem_.images[i].observed) edge_terms_[i].h /= options_.covariance_inflation;
    }
    for (PairTerm& pair : pairs_) {
      for (Matrix6d* h : {&pair.h_aa, &pair.h_ab, &pair.h_bb}) *h /= options_.covariance_inflation;
    }
  }

  JointResult result() {
    JointResult result;
    const std::vector<PoseGuess> from_others = guesses_from_others();
    inflate_evidence();
    assemble();
    factorise(information_);
    const SelectedInverse inverse(factor_);
    for (size_t i = 0; i < poses_.size(); ++i) {
      result.poses.push_back({poses_[i], covariance_block(inverse, i, i), from_others[i]});
    }
    for (const auto& [camera, value] : shared_) {
      SharedErrors errors;
      const int column = shared_column_.at(camera);
      errors.num_images = static_cast<int>(problem_.sequences.at(camera).size());
      errors.extrinsic = value.head<6>();
      const auto sigma = [&](int k) { return std::sqrt(inverse.at(column + k, column + k)); };
      for (int k = 0; k < 6; ++k) errors.extrinsic_sigmas(k) = sigma(k);
      errors.time_offset_s = value(6);
      errors.time_offset_sigma_s = sigma(6);
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
  Drift drift_;
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
