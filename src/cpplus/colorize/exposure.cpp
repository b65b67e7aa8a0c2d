#include "cpplus/colorize/exposure.h"

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <unordered_set>

namespace cpplus {
namespace {

constexpr size_t kNumCoefficients = std::tuple_size_v<VignettingCoefficients>;
constexpr int kNumIterations = 12;
constexpr size_t kMinObservations = 20;
constexpr double kMaxCornerSigma = 0.03;
/// Gains and coefficients are of this size, natural logarithms; keeps the system regular, and hardly bends it.
constexpr double kPriorSigma = 0.5;
/// Residuals below this are agreement: rounding to grey levels.
constexpr double kMinResidual = 0.005;

using SparseMatrix = Eigen::SparseMatrix<double>;

/// The row of the design matrix of one observation, by unknowns: the image, then its camera's coefficients.
struct Row {
  std::array<uint32_t, 1 + kNumCoefficients> unknowns;
  std::array<double, 1 + kNumCoefficients> values;
  size_t size = 0;

  void add(size_t unknown, double value) {
    unknowns[size] = static_cast<uint32_t>(unknown);
    values[size++] = value;
  }
};

/// The normal equations with the brightness of each point eliminated:
///   H = sum over points of (sum w h h' - (sum w h)(sum w h)' / sum w).
class ExposureSolver {
 public:
  ExposureSolver(const ExposureObservations& observations, const std::vector<uint32_t>& camera_of_image,
                 const std::vector<bool>& use_image, const std::vector<bool>& use_camera)
      : observations_(observations), camera_of_image_(camera_of_image), use_image_(use_image), use_camera_(use_camera) {
    const size_t size = camera_of_image.size() + kNumCoefficients * use_camera.size();
    solution_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(size));
    residuals_.resize(observations.observations.size());
    find_unknowns();
    make_pattern();
    factor_.analyzePattern(normal_matrix_);
  }

  void solve() {
    for (int i = 0; i < kNumIterations; ++i) {
      update_residuals();
      accumulate();
      factor_.factorize(normal_matrix_);
      solution_ = factor_.solve(right_side_);
    }
    update_residuals();
  }

  double log_gain(size_t image) const { return solution_[static_cast<Eigen::Index>(image)]; }
  double coefficient(size_t camera, size_t k) const {
    return solution_[static_cast<Eigen::Index>(first_coefficient(camera) + k)];
  }
  double residual() const { return scale_; }

  /// Standard deviation of the camera's log vignetting at the corner.
  double corner_sigma(size_t camera) const {
    Eigen::VectorXd corner = Eigen::VectorXd::Zero(solution_.size());
    for (size_t k = 0; k < kNumCoefficients; ++k) corner[static_cast<Eigen::Index>(first_coefficient(camera) + k)] = 1;
    return std::sqrt(corner.dot(factor_.solve(corner)));
  }

 private:
  size_t first_coefficient(size_t camera) const { return camera_of_image_.size() + kNumCoefficients * camera; }

  Row row(const ExposureObservation& observation) const {
    Row row;
    if (use_image_[observation.image]) row.add(observation.image, 1.0);
    const uint32_t camera = camera_of_image_[observation.image];
    if (!use_camera_[camera]) return row;
    const double r2 = static_cast<double>(observation.radius) * static_cast<double>(observation.radius);
    double power = 1.0;
    for (size_t k = 0; k < kNumCoefficients; ++k) row.add(first_coefficient(camera) + k, power *= r2);
    return row;
  }

  /// The unknowns of each point, ascending.
  void find_unknowns() {
    for (size_t point = 0; point < observations_.num_points(); ++point) {
      const auto begin = static_cast<std::ptrdiff_t>(unknowns_.size());
      for (size_t i = observations_.point_begin[point]; i < observations_.point_begin[point + 1]; ++i) {
        const Row r = row(observations_.observations[i]);
        unknowns_.insert(unknowns_.end(), r.unknowns.begin(), r.unknowns.begin() + static_cast<std::ptrdiff_t>(r.size));
      }
      std::sort(unknowns_.begin() + begin, unknowns_.end());
      unknowns_.erase(std::unique(unknowns_.begin() + begin, unknowns_.end()), unknowns_.end());
      unknowns_begin_.push_back(unknowns_.size());
    }
  }

  std::span<const uint32_t> unknowns_of_point(size_t point) const {
    return {unknowns_.data() + unknowns_begin_[point], unknowns_begin_[point + 1] - unknowns_begin_[point]};
  }

  /// Entries on and below the diagonal that any point touches.
  void make_pattern() {
    std::unordered_set<uint64_t> entries;
    for (uint64_t i = 0; i < static_cast<uint64_t>(solution_.size()); ++i) entries.insert(i << 32 | i);
    for (size_t point = 0; point < observations_.num_points(); ++point) {
      const std::span<const uint32_t> unknowns = unknowns_of_point(point);
      for (size_t a = 0; a < unknowns.size(); ++a) {
        for (size_t b = 0; b <= a; ++b) entries.insert(uint64_t{unknowns[b]} << 32 | unknowns[a]);
      }
    }
    std::vector<Eigen::Triplet<double>> triplets;
    triplets.reserve(entries.size());
    for (const uint64_t entry : entries) {
      triplets.emplace_back(static_cast<int>(entry & 0xFFFFFFFFu), static_cast<int>(entry >> 32), 0.0);
    }
    normal_matrix_.resize(solution_.size(), solution_.size());
    normal_matrix_.setFromTriplets(triplets.begin(), triplets.end());
  }

  double predicted(const ExposureObservation& observation) const {
    const Row r = row(observation);
    double sum = 0.0;
    for (size_t k = 0; k < r.size; ++k) sum += r.values[k] * solution_[r.unknowns[k]];
    return sum;
  }

  /// Of a residual in units of the scale. Beyond a few times the scale nothing is left.
  static double robust_weight(double normalized) {
    const double u = 0.5 * normalized;
    return 1.0 / ((1.0 + u * u) * (1.0 + u * u));
  }

  double weight(size_t i) const {
    const double base = static_cast<double>(observations_.observations[i].weight);
    return scale_ > 0.0 ? base * robust_weight(residuals_[i] / scale_) : base;
  }

  /// Residuals about the brightness of each point that fits its other observations' weights best, and their scale.
  void update_residuals() {
    for (size_t point = 0; point < observations_.num_points(); ++point) {
      double sum = 0.0, total = 0.0;
      const size_t begin = observations_.point_begin[point], end = observations_.point_begin[point + 1];
      for (size_t i = begin; i < end; ++i) {
        const ExposureObservation& observation = observations_.observations[i];
        const double w = weight(i);  // by the last residual
        residuals_[i] = static_cast<double>(observation.log_light) - predicted(observation);
        sum += w * residuals_[i];
        total += w;
      }
      for (size_t i = begin; i < end; ++i) residuals_[i] = total > 0.0 ? residuals_[i] - sum / total : 0.0;
    }
    scale_ = noise();
  }

  /// Standard deviation of log_light, from differences within points: unlike the residuals these do not shrink when
  /// the brightness of a point follows one of its few observations.
  double noise() const {
    std::vector<double> sizes;
    for (size_t point = 0; point < observations_.num_points(); ++point) {
      for (size_t i = observations_.point_begin[point] + 1; i < observations_.point_begin[point + 1]; ++i) {
        sizes.push_back(std::abs(residuals_[i] - residuals_[i - 1]));
      }
    }
    if (sizes.empty()) return kMinResidual;
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    constexpr double kSigmaOfMedian = 1.4826;
    return std::max(kMinResidual, kSigmaOfMedian * *middle / std::sqrt(2.0));
  }

  void accumulate() {
    std::fill(normal_matrix_.valuePtr(), normal_matrix_.valuePtr() + normal_matrix_.nonZeros(), 0.0);
    right_side_ = Eigen::VectorXd::Zero(solution_.size());
    for (Eigen::Index i = 0; i < solution_.size(); ++i) {
      normal_matrix_.coeffRef(i, i) = 1.0 / (kPriorSigma * kPriorSigma);
    }
    for (size_t point = 0; point < observations_.num_points(); ++point) add_point(point);
  }

  void add_point(size_t point) {
    const std::span<const uint32_t> unknowns = unknowns_of_point(point);
    const size_t size = unknowns.size();
    point_.reset(size);
    for (size_t i = observations_.point_begin[point]; i < observations_.point_begin[point + 1]; ++i) {
      const Row r = row(observations_.observations[i]);
      std::array<size_t, 1 + kNumCoefficients> places;  // ascending, as the unknowns of a row are
      for (size_t k = 0; k < r.size; ++k) {
        const auto found = std::lower_bound(unknowns.begin(), unknowns.end(), r.unknowns[k]);
        places[k] = static_cast<size_t>(found - unknowns.begin());
      }
      const double w = weight(i) / (scale_ * scale_);
      const double value = static_cast<double>(observations_.observations[i].log_light);
      for (size_t k = 0; k < r.size; ++k) {
        for (size_t l = 0; l <= k; ++l) point_.at(places[k], places[l]) += w * r.values[k] * r.values[l];
        point_.weighted_sum[places[k]] += w * r.values[k];
        point_.right[places[k]] += w * value * r.values[k];
      }
      point_.sum += w * value;
      point_.total += w;
    }
    if (point_.total > 0.0) add_to_normal_equations(unknowns);
  }

  /// Eliminates the brightness of the point.
  void add_to_normal_equations(std::span<const uint32_t> unknowns) {
    for (size_t b = 0; b < unknowns.size(); ++b) {
      right_side_[unknowns[b]] += point_.right[b] - point_.weighted_sum[b] * (point_.sum / point_.total);
      const int* row = normal_matrix_.innerIndexPtr() + normal_matrix_.outerIndexPtr()[unknowns[b]];
      const int* end = normal_matrix_.innerIndexPtr() + normal_matrix_.outerIndexPtr()[unknowns[b] + 1];
      for (size_t a = b; a < unknowns.size(); ++a) {
        row = std::lower_bound(row, end, static_cast<int>(unknowns[a]));
        normal_matrix_.valuePtr()[row - normal_matrix_.innerIndexPtr()] +=
            point_.at(a, b) - point_.weighted_sum[a] * point_.weighted_sum[b] / point_.total;
      }
    }
  }

  /// The sums of one point over its observations, by places among its unknowns.
  struct PointSums {
    std::vector<double> matrix;               // sum w h h', on and below the diagonal, by rows
    std::vector<double> weighted_sum, right;  // sum w h, sum w h value
    double sum = 0.0, total = 0.0;            // sum w value, sum w
    size_t size = 0;

    void reset(size_t num_unknowns) {
      size = num_unknowns;
      matrix.assign(size * size, 0.0);
      weighted_sum.assign(size, 0.0);
      right.assign(size, 0.0);
      sum = total = 0.0;
    }
    double& at(size_t row, size_t column) { return matrix[row * size + column]; }
  };

  const ExposureObservations& observations_;
  const std::vector<uint32_t>& camera_of_image_;
  const std::vector<bool>& use_image_;
  const std::vector<bool>& use_camera_;
  std::vector<uint32_t> unknowns_;
  std::vector<size_t> unknowns_begin_ = {0};  // of points and one more
  PointSums point_;                           // kept for its memory
  SparseMatrix normal_matrix_;                // on and below the diagonal
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> factor_;
  Eigen::VectorXd right_side_, solution_;
  std::vector<double> residuals_;
  double scale_ = 0.0;  // 0 = not known yet
};

/// For each image the smallest index of those that it is connected to by points.
std::vector<uint32_t> connected_images(const ExposureObservations& observations, size_t num_images) {
  std::vector<uint32_t> parent(num_images);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](uint32_t image) {
    while (parent[image] != image) image = parent[image] = parent[parent[image]];
    return image;
  };
  for (size_t point = 0; point < observations.num_points(); ++point) {
    const size_t begin = observations.point_begin[point], end = observations.point_begin[point + 1];
    for (size_t i = begin + 1; i < end; ++i) {
      const uint32_t a = root(observations.observations[begin].image), b = root(observations.observations[i].image);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  for (uint32_t image = 0; image < num_images; ++image) parent[image] = root(image);
  return parent;
}

std::vector<bool> images_with_enough(const ExposureObservations& observations, size_t num_images) {
  std::vector<size_t> counts(num_images, 0);
  for (const ExposureObservation& observation : observations.observations) ++counts[observation.image];
  std::vector<bool> enough(num_images);
  for (size_t i = 0; i < num_images; ++i) enough[i] = counts[i] >= kMinObservations;
  return enough;
}

/// Takes the mean of the determined images out of each connected set.
void center_gains(const std::vector<uint32_t>& set_of_image, std::vector<ImageExposure>* images) {
  std::vector<double> sums(images->size(), 0.0), counts(images->size(), 0.0);
  for (size_t i = 0; i < images->size(); ++i) {
    if (!(*images)[i].determined) continue;
    sums[set_of_image[i]] += (*images)[i].log_gain;
    counts[set_of_image[i]] += 1.0;
  }
  for (size_t i = 0; i < images->size(); ++i) {
    if ((*images)[i].determined) (*images)[i].log_gain -= sums[set_of_image[i]] / counts[set_of_image[i]];
  }
}

}  // namespace

double log_vignetting(const VignettingCoefficients& coefficients, double radius) {
  const double r2 = radius * radius;
  return r2 * (coefficients[0] + r2 * (coefficients[1] + r2 * coefficients[2]));
}

ExposureModel estimate_exposure(const ExposureObservations& observations, const std::vector<uint32_t>& camera_of_image,
                                size_t num_cameras, const ExposureOptions& options) {
  ExposureModel model;
  model.images.resize(camera_of_image.size());
  model.cameras.resize(num_cameras);
  if (observations.observations.empty() || (!options.gains && !options.vignetting)) return model;

  const std::vector<bool> enough = images_with_enough(observations, camera_of_image.size());
  const std::vector<bool> use_image = options.gains ? enough : std::vector<bool>(enough.size(), false);
  std::vector<bool> use_camera(num_cameras, options.vignetting);
  // What turns out not to be determined is left out, and the rest solved again.
  for (bool again = true; again;) {
    ExposureSolver solver(observations, camera_of_image, use_image, use_camera);
    solver.solve();
    again = false;
    for (size_t camera = 0; camera < num_cameras; ++camera) {
      model.cameras[camera] = {};
      if (!use_camera[camera]) continue;
      if (solver.corner_sigma(camera) > kMaxCornerSigma) {
        use_camera[camera] = false;
        again = true;
        continue;
      }
      model.cameras[camera].determined = true;
      for (size_t k = 0; k < kNumCoefficients; ++k) {
        model.cameras[camera].coefficients[k] = solver.coefficient(camera, k);
      }
    }
    for (size_t i = 0; i < use_image.size(); ++i) {
      model.images[i] = {use_image[i] ? solver.log_gain(i) : 0.0, use_image[i]};
    }
    model.residual = solver.residual();
  }
  center_gains(connected_images(observations, camera_of_image.size()), &model.images);
  return model;
}

}  // namespace cpplus
