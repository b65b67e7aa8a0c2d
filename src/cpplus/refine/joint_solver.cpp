#include "cpplus/refine/joint_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "cpplus/core/parallel.h"
#include "cpplus/refine/drift_model.h"
#include "cpplus/refine/joint_terms.h"
#include "cpplus/refine/normal_equations.h"
#include "cpplus/refine/selected_inverse.h"
#include "cpplus/refine/unproven_directions.h"

namespace cpplus {
namespace {

constexpr int kMaxSteps = 12;
// Scale of the patches' loss in the first round, in that of the last: poses that start tens of pixels off are drawn in
// by all their patches before outliers lose their weight (graduated non-convexity).
constexpr double kFirstPatchLoss = 16.0;
// Least and largest size of the drift, in prior sigmas.
constexpr double kMinDrift = 0.03;
constexpr double kMaxDrift = 2.0;
constexpr int kLearningSteps = 3;  // a round

// Above this share of its prior deviation the data say little of a parameter.
constexpr double kUndetermined = 0.7;

// Names of a camera's parameters that keep about their prior; sigmas in those of the prior.
std::vector<std::string> undetermined_parameters(const Imaging& imaging, const Eigen::VectorXd& sigma_ratios) {
  std::vector<std::string> names = {"rotation x",    "rotation y",    "rotation z", "translation x",
                                    "translation y", "translation z", "time offset"};
  if (imaging.has_readout()) names.emplace_back("readout");
  if (imaging.num_intrinsics() > 0) {
    for (const std::string& name : camera_model_param_names(imaging.camera().model())) names.push_back(name);
  }
  std::vector<std::string> undetermined;
  for (size_t k = 0; k < names.size(); ++k) {
    if (sigma_ratios(static_cast<Eigen::Index>(k)) > kUndetermined) undetermined.push_back(names[k]);
  }
  return undetermined;
}

using Vector1d = Eigen::Matrix<double, 1, 1>;

class JointSolver {
 public:
  JointSolver(const JointProblem& problem, const Vector6d& prior_sigmas, const JointEdgeOptions& edges,
              const JointOptions& options)
      : problem_(problem), prior_sigmas_(prior_sigmas), edge_options_(edges), options_(options) {
    for (const JointImage& image : problem.images) poses_.push_back(image.camera_from_map);
    matches_.resize(poses_.size());
    in_sequence_.resize(poses_.size(), false);
    own_terms_.resize(poses_.size());
    free_.resize(poses_.size(), PoseDirections(6, 0));
    int column = static_cast<int>(6 * poses_.size());
    for (const auto& [camera, sequence] : problem.sequences) {
      shared_column_[camera] = column;
      add_camera(camera, sequence);
      column += static_cast<int>(shared_.at(camera).size());
      for (const auto& [time, i] : sequence) in_sequence_[i] = true;
    }
    num_unknowns_ = column;
    group_matches();
    if (!pairs_.empty() && options.range_scale_sigma > 0) {
      range_scale_ = 0.0;
      range_scale_column_ = num_unknowns_++;
    }
  }

  JointResult run() {
    for (int round = 0; round < options_.rounds; ++round) {
      if (round > 0) free_unproven_directions();
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
  // Of each camera: extrinsic error, time offset, then the parameters of its Imaging.
  using SharedValues = std::map<uint32_t, Eigen::VectorXd>;
  static constexpr int kTimeOffset = 6;
  static constexpr int kImaging = 7;

  void add_camera(uint32_t camera, const std::vector<std::pair<double, size_t>>& sequence) {
    std::vector<double> gaps;
    for (size_t k = 1; k < sequence.size(); ++k) gaps.push_back(sequence[k].first - sequence[k - 1].first);
    std::sort(gaps.begin(), gaps.end());
    typical_gap_[camera] = gaps.empty() ? 1.0 : std::max(1e-9, gaps[gaps.size() / 2]);
    const bool has_velocities = std::any_of(sequence.begin(), sequence.end(), [&](const auto& at) {
      return problem_.images[at.second].velocity_per_s.has_value();
    });
    const Camera* taken_by = problem_.images[sequence.front().second].camera;
    const Imaging imaging(taken_by != nullptr ? *taken_by : Camera(), has_velocities, options_.imaging);
    imaging_.emplace(camera, imaging);
    Eigen::VectorXd values = Eigen::VectorXd::Zero(kImaging + imaging.num_parameters());
    values.tail(imaging.num_parameters()) = imaging.values();
    shared_[camera] = prior_means_[camera] = values;
  }

  void group_matches() {
    std::map<std::pair<size_t, size_t>, std::vector<const SurfaceMatch*>> pairs;
    for (const SurfaceMatch& m : problem_.matches) {
      if (in_sequence_[m.image_a] && in_sequence_[m.image_b]) pairs[{m.image_a, m.image_b}].push_back(&m);
    }
    const double own = options_.patch_sigma_px * options_.patch_sigma_px;
    const double common = options_.plane_sigma_px * options_.plane_sigma_px;
    for (auto& [images, matches] : pairs) {
      SharedPatches pair;
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
    pair_terms_.resize(pairs_.size());
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
      const EdgeEvidence* edges = problem_.images[i].edges;
      if (edges == nullptr || !in_sequence_[i]) return;
      const ImageState image = state(i, poses_[i]);
      matches_[i] = edges->match(image.imaging->camera(), image.pose(), radius_px, edge_options_.noise, edges->all());
    });
    for (const auto& [camera, imaging] : imaging_) matched_readout_s_[camera] = imaging.readout_s();
  }

  ImageState state(size_t i, const Rigid3& pose) const {
    return {pose, velocity(i), &imaging_.at(problem_.images[i].camera_id)};
  }

  EvidenceTerm own_term(size_t i, const Rigid3& pose) const {
    const JointImage& image = problem_.images[i];
    if (!in_sequence_[i]) return EvidenceTerm();
    if (image.observed) {
      return observation_term(*image.observed, image.observed->information / options_.covariance_inflation, pose);
    }
    EvidenceTerm term =
        edge_term(matches_[i], state(i, pose), matched_readout_s_.at(image.camera_id), edge_options_.loss_scale);
    free_directions(free_[i], prior_sigmas_, &term);
    if (image.intensities != nullptr) {
      add_intensity_matches(*image.intensities, state(i, pose), patch_loss_scale_, &term);
    }
    return term;
  }

  void free_unproven_directions() {
    parallel_for_each(poses_.size(), [&](size_t i) {
      const EdgeEvidence* edges = problem_.images[i].edges;
      if (edges == nullptr || !in_sequence_[i]) return;
      const ImagePose pose = state(i, poses_[i]).pose();
      const Camera& camera = imaging_.at(problem_.images[i].camera_id).camera();
      const EdgeEvidence::Selection all = edges->all();
      free_[i] = unproven_directions(own_terms_[i].h.topLeftCorner<6, 6>(), prior_sigmas_, edge_options_.min_log_gain,
                                     [&](const Vector6d& delta) {
                                       const ImagePose moved(perturb_camera(pose.camera_from_map, delta), pose.motion);
                                       return edges->log_ratio(camera, moved, edge_options_.kernel_px, all);
                                     });
    });
  }

  PatchNoise patch_noise() const {
    return {std::pow(options_.patch_sigma_px, 2) + std::pow(options_.plane_sigma_px, 2), patch_loss_scale_};
  }

  // Correction of the coarse pose that is not explained by what the images share.
  Vector6d drift(size_t i, const std::vector<Rigid3>& poses, const SharedValues& shared) const {
    const JointImage& image = problem_.images[i];
    const Eigen::VectorXd& s = shared.at(image.camera_id);
    return camera_difference(image.coarse_camera_from_map, poses[i]) - s.head<6>() - velocity(i) * s(kTimeOffset);
  }

  Vector6d velocity(size_t i) const { return problem_.images[i].velocity_per_s.value_or(Vector6d::Zero()); }

  // Between image k of a sequence and the one before, in typical gaps.
  double gap_before(uint32_t camera, const std::vector<std::pair<double, size_t>>& sequence, size_t k) const {
    return std::max(1e-3, (sequence[k].first - sequence[k - 1].first) / typical_gap_.at(camera));
  }

  Eigen::VectorXd shared_sigmas(uint32_t camera) const {
    const Eigen::VectorXd& of_imaging = imaging_.at(camera).prior_sigmas();
    Eigen::VectorXd sigmas(kImaging + of_imaging.size());
    sigmas << 2.0 * prior_sigmas_, options_.time_offset_sigma_s, of_imaging;
    return sigmas;
  }

  double prior_cost(const std::vector<Rigid3>& poses, const SharedValues& shared,
                    const std::optional<double>& range_scale) const {
    double cost = range_scale ? std::pow(*range_scale / options_.range_scale_sigma, 2) : 0.0;
    for (const auto& [camera, sequence] : problem_.sequences) {
      cost += (shared.at(camera) - prior_means_.at(camera)).cwiseQuotient(shared_sigmas(camera)).squaredNorm();
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

  double evaluate_all(const std::vector<Rigid3>& poses, const SharedValues& shared,
                      const std::optional<double>& range_scale) {
    for (auto& [camera, imaging] : imaging_) imaging.set_values(shared.at(camera).tail(imaging.num_parameters()));
    parallel_for_each(poses.size(), [&](size_t i) { own_terms_[i] = own_term(i, poses[i]); });
    parallel_for_each(pairs_.size(), [&](size_t k) {
      const SharedPatches& pair = pairs_[k];
      pair_terms_[k] =
          patch_term(pair, state(pair.a, poses[pair.a]), state(pair.b, poses[pair.b]), range_scale, patch_noise());
    });
    double cost = prior_cost(poses, shared, range_scale);
    for (const EvidenceTerm& term : own_terms_) cost += term.cost;
    for (const EvidenceTerm& term : pair_terms_) cost += term.cost;
    return cost;
  }

  // Columns of the unknowns of terms in which an image has a part.
  void append_pose_columns(size_t i, std::vector<int>* columns) const {
    for (int k = 0; k < 6; ++k) columns->push_back(static_cast<int>(6 * i) + k);
  }
  void append_imaging_columns(size_t i, std::vector<int>* columns) const {
    const uint32_t camera = problem_.images[i].camera_id;
    for (int k = 0; k < imaging_.at(camera).num_parameters(); ++k) {
      columns->push_back(shared_column_.at(camera) + kImaging + k);
    }
  }
  // An observation has no part in the imaging.
  std::vector<int> own_columns(size_t i) const {
    std::vector<int> columns;
    append_pose_columns(i, &columns);
    if (own_terms_[i].g.size() > 6) append_imaging_columns(i, &columns);
    return columns;
  }
  std::vector<int> pair_columns(const SharedPatches& pair) const {
    std::vector<int> columns;
    append_pose_columns(pair.a, &columns);
    append_pose_columns(pair.b, &columns);
    append_imaging_columns(pair.a, &columns);
    append_imaging_columns(pair.b, &columns);
    if (range_scale_) columns.push_back(range_scale_column_);
    return columns;
  }

  Eigen::Matrix<double, 6, 7> shared_design(size_t i) const {
    Eigen::Matrix<double, 6, 7> design;
    design << -Matrix6d::Identity(), -velocity(i);
    return design;
  }

  void assemble() {
    equations_.clear(num_unknowns_);
    for (size_t i = 0; i < poses_.size(); ++i) {
      if (!in_sequence_[i]) equations_.add_diagonal(static_cast<int>(6 * i), Vector6d::Ones(), Vector6d::Zero());
      equations_.add(own_columns(i), own_terms_[i].h, own_terms_[i].g);
    }
    for (size_t k = 0; k < pairs_.size(); ++k) {
      equations_.add(pair_columns(pairs_[k]), pair_terms_[k].h, pair_terms_[k].g);
    }
    for (const auto& [camera, sequence] : problem_.sequences) assemble_sequence(camera, sequence);
    if (range_scale_) {
      equations_.add_diagonal(range_scale_column_, Vector1d(std::pow(options_.range_scale_sigma, -2)),
                              Vector1d(*range_scale_));
    }
  }

  void assemble_sequence(uint32_t camera, const std::vector<std::pair<double, size_t>>& sequence) {
    const int shared_column = shared_column_.at(camera);
    const Eigen::VectorXd w = shared_sigmas(camera).cwiseAbs2().cwiseInverse();
    equations_.add_diagonal(shared_column, w, shared_.at(camera) - prior_means_.at(camera));
    for (size_t k = 0; k < sequence.size(); ++k) {
      const size_t i = sequence[k].second;
      const int column = static_cast<int>(6 * i);
      const Vector6d d = drift(i, poses_, shared_);
      if (k == 0) {
        equations_.add_linear({{column, Matrix6d::Identity()}, {shared_column, shared_design(i)}}, d,
                              drift_.sigmas().cwiseProduct(prior_sigmas_));
        continue;
      }
      const size_t before = sequence[k - 1].second;
      const double gap = gap_before(camera, sequence, k);
      const Matrix6d memory = drift_.correlations(gap).asDiagonal();
      equations_.add_linear({{column, Matrix6d::Identity()},
                             {static_cast<int>(6 * before), -memory},
                             {shared_column, shared_design(i) - memory * shared_design(before)}},
                            d - memory * drift(before, poses_, shared_),
                            drift_.innovation_sigmas(gap).cwiseProduct(prior_sigmas_));
    }
  }

  // Levenberg-Marquardt with weights of the robust loss fixed in each step.
  void minimise() {
    double cost = evaluate_all(poses_, shared_, range_scale_);
    double damping = 1e-6;
    for (int step = 0; step < kMaxSteps; ++step) {
      assemble();
      const Eigen::VectorXd x = equations_.step(damping);
      std::vector<Rigid3> poses = poses_;
      SharedValues shared = shared_;
      for (size_t i = 0; i < poses.size(); ++i) {
        poses[i] = perturb_camera(poses[i], x.segment<6>(static_cast<Eigen::Index>(6 * i)));
      }
      for (auto& [camera, value] : shared) value += x.segment(shared_column_.at(camera), value.size());
      std::optional<double> range_scale = range_scale_;
      if (range_scale) *range_scale += x(range_scale_column_);
      const double new_cost = evaluate_all(poses, shared, range_scale);
      if (!(new_cost < cost)) {
        damping = std::max(1e-4, 10.0 * damping);
        cost = evaluate_all(poses_, shared_, range_scale_);
        if (damping > 1e4) break;
        continue;
      }
      const bool converged = cost - new_cost < 1e-4 * (1.0 + cost) * 1e-2;
      poses_ = std::move(poses);
      shared_ = std::move(shared);
      range_scale_ = range_scale;
      cost = new_cost;
      damping = std::max(1e-9, 0.1 * damping);
      if (converged) break;
    }
  }

  SelectedInverse inverse_information() {
    evaluate_all(poses_, shared_, range_scale_);
    assemble();
    return equations_.inverse();
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
    const SelectedInverse inverse = inverse_information();
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

  // Information of everything but the image's own evidence on its pose and the parameters that this depends on, from
  // the inverse of all of it.
  Eigen::LDLT<Eigen::MatrixXd> information_of_others(size_t i, const SelectedInverse& inverse) const {
    const std::vector<int> columns = own_columns(i);
    const auto count = static_cast<Eigen::Index>(columns.size());
    Eigen::MatrixXd covariance(count, count);
    for (Eigen::Index r = 0; r < count; ++r) {
      for (Eigen::Index c = 0; c < count; ++c) {
        covariance(r, c) = inverse.at(columns[static_cast<size_t>(r)], columns[static_cast<size_t>(c)]);
      }
    }
    return Eigen::LDLT<Eigen::MatrixXd>(covariance.inverse() - own_terms_[i].h);
  }

  static Matrix6d pose_covariance(const Eigen::LDLT<Eigen::MatrixXd>& information) {
    return information.solve(Eigen::MatrixXd::Identity(information.rows(), information.cols())).topLeftCorner<6, 6>();
  }

  // At the minimum all gradients add up to zero: that of everything else is minus that of the image's own edges.
  std::vector<PoseGuess> guesses_from_others() {
    const SelectedInverse inverse = inverse_information();
    std::vector<PoseGuess> guesses;
    for (size_t i = 0; i < poses_.size(); ++i) {
      const Eigen::LDLT<Eigen::MatrixXd> rest = information_of_others(i, inverse);
      const Vector6d step = rest.solve(own_terms_[i].g).head<6>();
      guesses.emplace_back(perturb_camera(poses_[i], step), pose_covariance(rest));
    }
    return guesses;
  }

  // Divides the information of edges and patches (that of observations is so already).
  void inflate_evidence() {
    for (size_t i = 0; i < poses_.size(); ++i) {
      if (!problem_.images[i].observed) own_terms_[i].h /= options_.covariance_inflation;
    }
    for (EvidenceTerm& term : pair_terms_) term.h /= options_.covariance_inflation;
  }

  JointResult result() {
    JointResult result;
    const std::vector<PoseGuess> from_others = guesses_from_others();
    inflate_evidence();
    assemble();
    const SelectedInverse inverse = equations_.inverse();
    for (size_t i = 0; i < poses_.size(); ++i) {
      Vector6d motion = Vector6d::Zero();
      if (in_sequence_[i]) motion = state(i, poses_[i]).pose().motion;
      const bool is_proven = problem_.images[i].edges != nullptr && free_[i].cols() == 0;
      result.poses.push_back({poses_[i], motion, covariance_block(inverse, i, i), from_others[i],
                              pose_covariance(information_of_others(i, inverse)), is_proven});
    }
    for (const auto& [camera, sequence] : problem_.sequences) {
      result.shared[camera] = shared_errors(camera, inverse, static_cast<int>(sequence.size()));
      result.cameras.emplace(camera, imaging_.at(camera).camera());
    }
    result.range_scale = range_scale_.value_or(0.0);
    return result;
  }

  SharedErrors shared_errors(uint32_t camera, const SelectedInverse& inverse, int num_images) const {
    const Eigen::VectorXd& value = shared_.at(camera);
    const Imaging& imaging = imaging_.at(camera);
    Eigen::VectorXd sigmas(value.size());
    for (Eigen::Index k = 0; k < sigmas.size(); ++k) {
      const Eigen::Index column = shared_column_.at(camera) + k;
      sigmas(k) = std::sqrt(inverse.at(column, column));
    }
    SharedErrors errors;
    errors.num_images = num_images;
    errors.extrinsic = value.head<6>();
    errors.extrinsic_sigmas = sigmas.head<6>();
    errors.time_offset_s = value(kTimeOffset);
    errors.time_offset_sigma_s = sigmas(kTimeOffset);
    if (imaging.has_readout()) errors.readout = Estimate{value(kImaging), sigmas(kImaging)};
    for (Eigen::Index k = value.size() - imaging.num_intrinsics(); k < value.size(); ++k) {
      errors.intrinsics.push_back({value(k) - prior_means_.at(camera)(k), sigmas(k)});
    }
    errors.undetermined = undetermined_parameters(imaging, sigmas.cwiseQuotient(shared_sigmas(camera)));
    if (range_scale_) {
      const double sigma = std::sqrt(inverse.at(range_scale_column_, range_scale_column_));
      errors.range_scale = Estimate{*range_scale_, sigma};
      if (sigma > kUndetermined * options_.range_scale_sigma) errors.undetermined.emplace_back("range scale");
    }
    return errors;
  }

  const JointProblem& problem_;
  const Vector6d prior_sigmas_;
  const JointEdgeOptions& edge_options_;
  const JointOptions& options_;
  std::vector<Rigid3> poses_;
  std::map<uint32_t, Imaging> imaging_;  // with the values in shared_
  std::map<uint32_t, double> matched_readout_s_;
  SharedValues shared_;
  SharedValues prior_means_;
  std::map<uint32_t, int> shared_column_;
  std::map<uint32_t, double> typical_gap_;
  std::vector<char> in_sequence_;  // others have no part; their columns are held by ones on the diagonal
  std::vector<std::vector<EdgeMatch>> matches_;
  std::vector<EvidenceTerm> own_terms_;  // of each image: its edges or its observation
  std::vector<PoseDirections> free_;     // of each image, of which its edges say nothing
  std::vector<SharedPatches> pairs_;
  std::vector<EvidenceTerm> pair_terms_;
  double patch_loss_scale_ = 1.0;
  PoseDrift drift_;                    // gaps in units of each camera's typical one
  std::optional<double> range_scale_;  // nothing where it is not solved for
  int range_scale_column_ = -1;
  int num_unknowns_ = 0;
  NormalEquations equations_;
};

}  // namespace

void JointOptions::validate() const {
  check_option(rounds >= 1, "rounds", "[1, inf)", rounds);
  check_option(patch_sigma_px > 0, "patch_sigma_px", "(0, inf)", patch_sigma_px);
  check_option(plane_sigma_px > 0, "plane_sigma_px", "(0, inf)", plane_sigma_px);
  check_option(range_scale_sigma >= 0, "range_scale_sigma", "[0, inf)", range_scale_sigma);
  check_option(time_offset_sigma_s > 0, "time_offset_sigma_s", "(0, inf)", time_offset_sigma_s);
  check_option(covariance_inflation >= 1, "covariance_inflation", "[1, inf)", covariance_inflation);
  imaging.validate();
}

JointResult solve_joint(const JointProblem& problem, const Vector6d& prior_sigmas, const JointEdgeOptions& edges,
                        const JointOptions& options) {
  return JointSolver(problem, prior_sigmas, edges, options).run();
}

}  // namespace cpplus
