#include "cpplus/features/intensity_matching.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "cpplus/core/vector_clones.h"
#include "cpplus/geometry/perturbed_pixel.h"

namespace cpplus {
namespace {

using PatchPoints = std::vector<const IntensityPoint*>;

// Each point is in four patches, which overlap by half in both directions.
constexpr double kPatchesPerPoint = 4.0;
// The pose must know a patch's place to this share of the search radius, one standard deviation; as wide is the prior.
constexpr double kMaxSpread = 0.5;
// Highest and lowest intensities of a patch that count as the quantiles at this share: mirrors and black glass.
constexpr double kTail = 0.02;
// Least contrast of a patch of the image, grey levels (root mean square).
constexpr float kMinContrast = 3.0f;
// Cells along a patch, over which an image is about constant. Intensities of which these explain less than this share
// of the least squared correlation are not looked at: half the time, and no match is lost (all of it loses some).
constexpr int kCells = 8;
constexpr double kMinExplained = 0.5;
// Higher ones count as this: the likelihood of a perfect one has no bound.
constexpr double kMaxCorrelation = 0.99;

// Points by squares of half a patch.
class HalfPatches {
 public:
  HalfPatches(const std::vector<IntensityPoint>& points, const GrayImage& image, int half_px, int border_px)
      : columns_(image.width / half_px), rows_(image.height / half_px) {
    squares_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));
    for (const IntensityPoint& point : points) {
      const int x = static_cast<int>(std::lround(point.pixel.x()));
      const int y = static_cast<int>(std::lround(point.pixel.y()));
      if (x < border_px || y < border_px || x >= image.width - border_px || y >= image.height - border_px) continue;
      if (x / half_px < columns_ && y / half_px < rows_) squares_[index(x / half_px, y / half_px)].push_back(&point);
    }
  }

  int columns() const { return columns_ - 1; }
  int rows() const { return rows_ - 1; }
  // Of the patch that begins with this square, an even choice.
  PatchPoints patch(int column, int row, size_t max_points) const {
    PatchPoints all;
    for (int j = row; j <= row + 1; ++j) {
      for (int i = column; i <= column + 1; ++i) {
        const PatchPoints& square = squares_[index(i, j)];
        all.insert(all.end(), square.begin(), square.end());
      }
    }
    if (all.size() <= max_points) return all;
    PatchPoints chosen(max_points);
    for (size_t k = 0; k < max_points; ++k) chosen[k] = all[k * all.size() / max_points];
    return chosen;
  }

 private:
  size_t index(int column, int row) const {
    return static_cast<size_t>(row) * static_cast<size_t>(columns_) + static_cast<size_t>(column);
  }

  int columns_, rows_;
  std::vector<PatchPoints> squares_;
};

Eigen::VectorXf clipped_intensities(const PatchPoints& points) {
  Eigen::VectorXf values(static_cast<Eigen::Index>(points.size()));
  for (size_t k = 0; k < points.size(); ++k) values(static_cast<Eigen::Index>(k)) = points[k]->intensity;
  Eigen::VectorXf sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const auto tail = static_cast<Eigen::Index>(kTail * static_cast<double>(points.size()));
  return values.cwiseMax(sorted(tail)).cwiseMin(sorted(sorted.size() - 1 - tail));
}

// Share of the intensities' variance that the places of points explain, by the variance left within cells of a patch.
// The square of their correlation with an image will hardly exceed it by much.
double explained_by_place(const PatchPoints& points, const Eigen::VectorXf& values, int patch_px) {
  struct Sums {
    double count = 0.0, sum = 0.0;
  };
  std::array<Sums, kCells * kCells> cells{};
  const auto cell = [&](float pixel) { return (static_cast<int>(pixel) * kCells / patch_px) % kCells; };
  for (size_t k = 0; k < points.size(); ++k) {
    const int index = cell(points[k]->pixel.y()) * kCells + cell(points[k]->pixel.x());
    Sums& at = cells[static_cast<size_t>(index)];
    at.count += 1.0;
    at.sum += static_cast<double>(values(static_cast<Eigen::Index>(k)));
  }
  const double count = static_cast<double>(values.size());
  const double squares = values.cast<double>().squaredNorm();
  const double total = squares - values.cast<double>().sum() * values.cast<double>().mean();
  double within = squares;
  double free = count;
  for (const Sums& at : cells) {
    if (at.count == 0.0) continue;
    within -= at.sum * at.sum / at.count;
    free -= 1.0;
  }
  if (!(total > 0.0) || free <= 0.0) return 0.0;
  return 1.0 - (within / free) / (total / (count - 1.0));
}

// A patch's points as the correlation needs them: their pixels as offsets in the image, their intensities (of unit
// norm, orthogonal to the basis) and an orthonormal basis of what is linear over the patch.
struct Pattern {
  struct Point {
    std::ptrdiff_t pixel = 0;
    std::array<float, 4> values{};  // intensity, then the basis
  };
  std::vector<Point> points;
  Eigen::Vector3d center_in_map = Eigen::Vector3d::Zero();
};

Pattern make_pattern(const PatchPoints& points, Eigen::VectorXf intensities, int image_width) {
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXf linear(count, 3);
  Pattern pattern;
  for (Eigen::Index k = 0; k < count; ++k) {
    const IntensityPoint& point = *points[static_cast<size_t>(k)];
    const Eigen::Vector2f from_first = point.pixel - points[0]->pixel;
    linear.row(k) << 1.0f, from_first.x(), from_first.y();
    pattern.center_in_map += point.x_in_map / static_cast<double>(count);
  }
  const Eigen::MatrixXf basis =
      Eigen::HouseholderQR<Eigen::MatrixXf>(linear).householderQ() * Eigen::MatrixXf::Identity(count, 3);
  intensities -= basis * (basis.transpose() * intensities);
  const float norm = intensities.norm();
  if (norm > 0.0f) intensities /= norm;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Vector2f& pixel = points[static_cast<size_t>(k)]->pixel;
    pattern.points.push_back(
        {std::lround(pixel.y()) * static_cast<std::ptrdiff_t>(image_width) + std::lround(pixel.x()),
         {intensities(k), basis(k, 0), basis(k, 1), basis(k, 2)}});
  }
  return pattern;
}

constexpr int kLanes = 8;
using Lanes = std::array<float, kLanes>;

// Sums over the points of a pattern, for kLanes shifts along a row: products of brightness with the pattern's values,
// then its square.
CPPLUS_VECTOR_CLONES
void sum_products(const float* image, const Pattern::Point* points, size_t count, std::array<Lanes, 5>* sums) {
  Lanes s0{}, s1{}, s2{}, s3{}, squares{};
  for (size_t k = 0; k < count; ++k) {
    const float* brightness = image + points[k].pixel;
    const std::array<float, 4>& values = points[k].values;
    for (size_t i = 0; i < kLanes; ++i) {
      const float b = brightness[i];
      s0[i] += values[0] * b;
      s1[i] += values[1] * b;
      s2[i] += values[2] * b;
      s3[i] += values[3] * b;
      squares[i] += b * b;
    }
  }
  *sums = {s0, s1, s2, s3, squares};
}

// Absolute correlations for all shifts, (2 r + 1) x (2 r + 1), rows of the matrix those of the image.
Eigen::MatrixXd correlations(const Image<float>& image, const Pattern& pattern, int radius_px) {
  const Eigen::Index width = 2 * radius_px + 1;
  const double min_squares = std::pow(kMinContrast, 2) * static_cast<double>(pattern.points.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(width, width);
  std::array<Lanes, 5> sums;
  for (int dy = -radius_px; dy <= radius_px; ++dy) {
    for (int dx = -radius_px; dx <= radius_px; dx += kLanes) {
      const std::ptrdiff_t shift = static_cast<std::ptrdiff_t>(dy) * image.width + dx;
      sum_products(image.pixels.data() + shift, pattern.points.data(), pattern.points.size(), &sums);
      for (size_t i = 0; i < kLanes && dx + static_cast<int>(i) <= radius_px; ++i) {
        double squares = sums[4][i];
        for (size_t basis = 1; basis <= 3; ++basis) squares -= std::pow(sums[basis][i], 2);
        if (squares < min_squares) continue;
        result(dy + radius_px, dx + radius_px + static_cast<int>(i)) = std::abs(sums[0][i]) / std::sqrt(squares);
      }
    }
  }
  return result;
}

struct Peak {
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();  // of the likelihood alone
  double correlation = 0.0;
};

// The peak of the likelihood, by a paraboloid through the 3x3 values around the most probable shift; nothing where that
// is no peak, or lies at the border.
std::optional<Peak> find_peak(const Eigen::MatrixXd& correlation, double measurements, double prior_sigma_px,
                              double min_correlation) {
  const double prior = 1.0 / (prior_sigma_px * prior_sigma_px);
  const Eigen::Index radius = correlation.rows() / 2;
  const Eigen::MatrixXd likelihood =
      -0.5 * measurements * (1.0 - correlation.array().min(kMaxCorrelation).square()).log();
  Eigen::MatrixXd posterior = likelihood;
  for (Eigen::Index x = 0; x < posterior.cols(); ++x) {
    for (Eigen::Index y = 0; y < posterior.rows(); ++y) {
      posterior(y, x) -= 0.5 * prior * static_cast<double>((x - radius) * (x - radius) + (y - radius) * (y - radius));
    }
  }
  Eigen::Index y = 0, x = 0;
  posterior.maxCoeff(&y, &x);
  if (x == 0 || y == 0 || x == 2 * radius || y == 2 * radius || correlation(y, x) < min_correlation) {
    return std::nullopt;
  }
  const Eigen::Matrix3d l = likelihood.block<3, 3>(y - 1, x - 1);
  const Eigen::Vector2d gradient(0.5 * (l(1, 2) - l(1, 0)), 0.5 * (l(2, 1) - l(0, 1)));
  const double mixed = 0.25 * (l(2, 2) - l(2, 0) - l(0, 2) + l(0, 0));
  Eigen::Matrix2d curvature;
  curvature << 2.0 * l(1, 1) - l(1, 2) - l(1, 0), -mixed, -mixed, 2.0 * l(1, 1) - l(2, 1) - l(0, 1);
  if (!(curvature.trace() > 0.0 && curvature.determinant() > 0.0)) return std::nullopt;  // a ridge or a saddle
  const Eigen::Vector2d step = curvature.inverse() * gradient;
  if (step.cwiseAbs().maxCoeff() > 1.0) return std::nullopt;
  Peak peak;
  peak.information = curvature;
  const Eigen::Vector2d highest(static_cast<double>(x - radius), static_cast<double>(y - radius));
  peak.shift_px = highest + step;
  peak.correlation = correlation(y, x);
  return peak;
}

Image<float> blurred(const GrayImage& image, double sigma_px) {
  Image<float> result(image.width, image.height);
  const cv::Mat gray(image.height, image.width, CV_8U, const_cast<uint8_t*>(image.pixels.data()));
  cv::Mat smooth(image.height, image.width, CV_32F, result.pixels.data());
  gray.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {0, 0}, sigma_px);
  return result;
}

class IntensityMatcher {
 public:
  IntensityMatcher(const GrayImage& image, const ExpectedView& view, const IntensityMatchingOptions& options)
      : image_(blurred(image, options.blur_sigma_px)), view_(view), options_(options) {}

  std::optional<IntensityMatch> match(const PatchPoints& points) const {
    if (static_cast<int>(points.size()) < options_.min_points) return std::nullopt;
    const Eigen::VectorXf intensities = clipped_intensities(points);
    const double explained = explained_by_place(points, intensities, options_.patch_px);
    if (explained < kMinExplained * options_.min_correlation * options_.min_correlation) return std::nullopt;
    const Pattern pattern = make_pattern(points, intensities, image_.width);
    const auto expected = project_perturbed(view_.camera, view_.camera_from_map * pattern.center_in_map);
    if (!expected || spread_px(*expected) > kMaxSpread * options_.search_radius_px) return std::nullopt;
    const auto peak = find_peak(correlations(image_, pattern, options_.search_radius_px),
                                static_cast<double>(points.size()) / options_.points_per_measurement,
                                kMaxSpread * options_.search_radius_px, options_.min_correlation);
    if (!peak) return std::nullopt;
    const Eigen::Matrix2d least_covariance =
        std::pow(options_.pixel_sigma_px, 2) * Eigen::Matrix2d::Identity() +
        std::pow(options_.map_sigma_m, 2) * expected->by_point * expected->by_point.transpose();
    IntensityMatch match;
    match.x_in_map = pattern.center_in_map;
    match.pixel = expected->pixel + peak->shift_px;
    match.information =
        peak->information * (Eigen::Matrix2d::Identity() + least_covariance * peak->information).inverse();
    match.weight = 1.0 / kPatchesPerPoint;
    match.correlation = peak->correlation;
    return match;
  }

 private:
  // Standard deviation of the pixel where it is largest.
  double spread_px(const PerturbedPixel& expected) const {
    const Eigen::Matrix2d covariance =
        expected.by_perturbation * view_.covariance * expected.by_perturbation.transpose();
    return std::sqrt(
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff());
  }

  Image<float> image_;
  const ExpectedView& view_;
  const IntensityMatchingOptions& options_;
};

}  // namespace

void IntensityMatchingOptions::validate() const {
  check_option(patch_px >= 16, "patch_px", "[16, inf)", patch_px);
  check_option(search_radius_px >= 2, "search_radius_px", "[2, inf)", search_radius_px);
  check_option(blur_sigma_px > 0, "blur_sigma_px", "(0, inf)", blur_sigma_px);
  check_option(min_points >= 16, "min_points", "[16, inf)", min_points);
  check_option(max_points >= 16, "max_points", "[16, inf)", max_points);
  check_option(min_correlation > 0 && min_correlation < 1, "min_correlation", "(0, 1)", min_correlation);
  check_option(points_per_measurement >= 1, "points_per_measurement", "[1, inf)", points_per_measurement);
  check_option(pixel_sigma_px >= 0, "pixel_sigma_px", "[0, inf)", pixel_sigma_px);
  check_option(map_sigma_m >= 0, "map_sigma_m", "[0, inf)", map_sigma_m);
}

std::vector<IntensityMatch> match_intensities(const std::vector<IntensityPoint>& points, const GrayImage& image,
                                              const ExpectedView& view, const IntensityMatchingOptions& options) {
  std::vector<IntensityMatch> matches;
  if (image.empty()) return matches;
  const HalfPatches patches(points, image, options.patch_px / 2, options.search_radius_px + kLanes);
  const IntensityMatcher matcher(image, view, options);
  for (int row = 0; row < patches.rows(); ++row) {
    for (int column = 0; column < patches.columns(); ++column) {
      const auto match = matcher.match(patches.patch(column, row, static_cast<size_t>(options.max_points)));
      if (match) matches.push_back(*match);
    }
  }
  return matches;
}

}  // namespace cpplus
