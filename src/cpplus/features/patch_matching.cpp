#include "cpplus/features/patch_matching.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "cpplus/core/vector_clones.h"

namespace cpplus {
namespace {

constexpr int kNumLevels = 3;
constexpr double kOcclusionMargin = 0.05;  // metres
// A patch that is seen more than so many times larger, smaller or slanted from the other view is not comparable.
constexpr double kMaxStretch = 2.5;
constexpr double kMinReach = 3.0;  // pixels of a level
// Once some patches are found the others are looked for where the nearest of these say.
constexpr size_t kGuides = 4;
constexpr double kGuidedRadiusPx = 8.0;

// Means of 2x2 pixels: pixel x of the half is at 2 x + 0.5 of the whole.
template <typename Pixel>
Image<float> halve(const Image<Pixel>& image) {
  Image<float> half(image.width / 2, image.height / 2);
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      half.at(x, y) = 0.25f * static_cast<float>(image.at(2 * x, 2 * y) + image.at(2 * x + 1, 2 * y) +
                                                 image.at(2 * x, 2 * y + 1) + image.at(2 * x + 1, 2 * y + 1));
    }
  }
  return half;
}

// Calls visit(image) with a level of the pyramid, the full image first.
template <typename Visit>
auto with_level(const PatchView& view, int level, const Visit& visit) {
  return level == 0 ? visit(view.image) : visit(view.halves[static_cast<size_t>(level - 1)]);
}

Eigen::Vector2d to_level(const Eigen::Vector2d& pixel, int level) {
  const double scale = std::ldexp(1.0, -level);
  return ((pixel.array() + 0.5) * scale - 0.5).matrix();
}

Eigen::Vector2d from_level(const Eigen::Vector2d& pixel, int level) {
  const double scale = std::ldexp(1.0, level);
  return ((pixel.array() + 0.5) * scale - 0.5).matrix();
}

// Bilinear; false where the four pixels are not all in the image.
template <typename Pixel>
bool interpolate(const Image<Pixel>& image, double x, double y, float* value) {
  if (!(x >= 0.0 && y >= 0.0 && x < image.width - 1 && y < image.height - 1)) return false;
  const int ix = static_cast<int>(x);
  const int iy = static_cast<int>(y);
  const float fx = static_cast<float>(x - ix);
  const float fy = static_cast<float>(y - iy);
  const Pixel* row = &image.at(ix, iy);
  const Pixel* next = row + image.width;
  const auto along = [fx](const Pixel* pixel) {
    const float left = pixel[0];
    return left + fx * (static_cast<float>(pixel[1]) - left);
  };
  *value = (1.0f - fy) * along(row) + fy * along(next);
  return true;
}

// Zero mean, unit norm; false for a patch without contrast.
bool normalise(std::vector<float>* values) {
  float sum = 0.0f;
  for (const float v : *values) sum += v;
  const float mean = sum / static_cast<float>(values->size());
  float squares = 0.0f;
  for (float& v : *values) {
    v -= mean;
    squares += v * v;
  }
  constexpr float kMinContrast = 2.0f;  // grey levels, RMS
  if (squares < kMinContrast * kMinContrast * static_cast<float>(values->size())) return false;
  const float inverse = 1.0f / std::sqrt(squares);
  for (float& v : *values) v *= inverse;
  return true;
}

constexpr int kLanes = 16;

// Products of the template with the kLanes patches of a row, the first of which begins at `pixels`.
CPPLUS_VECTOR_CLONES
void multiply_some(const float* pixels, int width, const float* values, int edge, float* products) {
  std::array<float, kLanes> product{};
  for (int y = 0; y < edge; ++y) {
    for (int x = 0; x < edge; ++x) {
      const float* v = pixels + y * width + x;
      const float t = values[y * edge + x];
      for (size_t k = 0; k < kLanes; ++k) product[k] += t * v[k];
    }
  }
  std::copy(product.begin(), product.end(), products);
}

std::optional<Eigen::Vector3d> on_plane(const PlaneBuffer& view, const MapPlane& plane, const Eigen::Vector2d& pixel) {
  const double range = view.range_of(plane, pixel);
  if (!std::isfinite(range)) return std::nullopt;
  return inverse(view.camera_from_map) * Eigen::Vector3d(range * *view.camera.unproject(pixel));
}

// How the plane carries pixels of view a around one of them to pixels of view b.
struct Transfer {
  Eigen::Vector2d pixel_b;
  Eigen::Matrix2d a_from_b;  // of offsets
};

std::optional<Transfer> transfer(const PatchView& a, const PatchView& b, const PatchView::Patch& patch) {
  const MapPlane& plane = patch.surface.plane;
  const Rigid3& b_from_map = b.planes.camera_from_map;
  const auto carry = [&](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector2d> {
    const auto x = on_plane(a.planes, plane, pixel);
    return x ? b.planes.camera.project(b_from_map * *x) : std::nullopt;
  };
  constexpr double kStep = 2.0;
  const auto center = carry(patch.pixel);
  const auto right = carry(patch.pixel + kStep * Eigen::Vector2d::UnitX());
  const auto below = carry(patch.pixel + kStep * Eigen::Vector2d::UnitY());
  if (!center || !right || !below || !b.planes.camera.in_image(*center)) return std::nullopt;
  const Eigen::Vector3d x = *on_plane(a.planes, plane, patch.pixel);
  if (!b.planes.is_visible(x, *center, kOcclusionMargin)) return std::nullopt;
  if (!is_seen(b.raster, *center, (b_from_map * x).norm())) return std::nullopt;
  // Both cameras on the same side of the surface.
  if (plane.signed_distance(camera_center(a.planes.camera_from_map)) *
          plane.signed_distance(camera_center(b_from_map)) <=
      0) {
    return std::nullopt;
  }
  Eigen::Matrix2d b_from_a;
  b_from_a << (*right - *center) / kStep, (*below - *center) / kStep;
  const Eigen::Vector2d stretch = b_from_a.jacobiSvd().singularValues();
  if (stretch(0) > kMaxStretch || stretch(1) < 1.0 / kMaxStretch) return std::nullopt;
  return Transfer{*center, b_from_a.inverse()};
}

class Matcher {
 public:
  Matcher(const PatchView& a, const PatchView& b, const PatchMatchingOptions& options)
      : a_(a), b_(b), options_(options), edge_(2 * options.radius_px + 1) {}

  // Looks for a patch within radius_px of where `carried` puts it.
  std::optional<SurfaceMatch> match(const PatchView::Patch& patch, const Transfer& carried, double radius_px) {
    Eigen::Vector2d pixel = carried.pixel_b;
    // What is one pixel wide or less on a level is not looked for there.
    int first_level = kNumLevels - 1;
    while (first_level > 0 && std::ldexp(radius_px, -first_level) < kMinReach) --first_level;
    for (int level = first_level; level >= 0; --level) {
      if (!make_template(patch.pixel, carried.a_from_b, level)) return std::nullopt;
      const bool first = level == first_level;
      const int reach = first ? static_cast<int>(std::ceil(std::ldexp(radius_px, -level))) : 2;
      if (!search(level, reach, first, &pixel)) return std::nullopt;
    }
    if (!settle(patch.pixel, carried.a_from_b, &pixel)) return std::nullopt;
    SurfaceMatch m;
    m.pixel_a = patch.pixel;
    m.pixel_b = pixel;
    m.plane = patch.surface.plane_id;
    m.point_in_map = patch.surface.plane.centroid;
    m.normal_in_map = patch.surface.plane.normal;
    m.range_sigma_m = patch.surface.range_sigma_m;
    m.correlation = correlation_;
    return m;
  }

 private:
  // The patch as view b should see it.
  bool make_template(const Eigen::Vector2d& pixel_a, const Eigen::Matrix2d& a_from_b, int level) {
    const Eigen::Vector2d center = to_level(pixel_a, level);
    return with_level(a_, level, [&](const auto& image) { return make_template(image, center, a_from_b); });
  }

  template <typename Pixel>
  bool make_template(const Image<Pixel>& image, const Eigen::Vector2d& center, const Eigen::Matrix2d& a_from_b) {
    template_.clear();
    for (int y = -options_.radius_px; y <= options_.radius_px; ++y) {
      for (int x = -options_.radius_px; x <= options_.radius_px; ++x) {
        const Eigen::Vector2d p = center + a_from_b * Eigen::Vector2d(x, y);
        float value = 0.0f;
        if (!interpolate(image, p.x(), p.y(), &value)) return false;
        template_.push_back(value);
      }
    }
    return normalise(&template_);
  }

  // Of the template with the patches of b around the whole pixels of a square, by rows; -1 where a patch is not all in
  // the image.
  template <typename Pixel>
  void correlate(const Image<Pixel>& image, int left, int top, int edge) {
    const int r = options_.radius_px;
    // The pixels under all these patches, those outside of the image as 0, and room for whole vectors.
    const int width = edge + edge_ - 1 + kLanes;
    const int height = edge + edge_ - 1;
    region_.assign(static_cast<size_t>(width) * static_cast<size_t>(height), 0.0f);
    const int first = std::max(left - r, 0), last = std::min(left + edge + r, image.width);
    for (int y = std::max(top - r, 0); y < std::min(top + edge + r, image.height); ++y) {
      float* row = region_.data() + (y - (top - r)) * width - (left - r);
      for (int x = first; x < last; ++x) row[x] = image.at(x, y);
    }
    sums_.resize(region_.size());
    sums_of_squares_.resize(region_.size());
    const cv::Mat region(height, width, CV_32F, region_.data());
    cv::Mat sums(height, width, CV_32F, sums_.data()), sums_of_squares(height, width, CV_32F, sums_of_squares_.data());
    const cv::Size box(edge_, edge_);
    const cv::Point first_corner(0, 0);
    cv::boxFilter(region, sums, CV_32F, box, first_corner, false, cv::BORDER_CONSTANT);
    cv::sqrBoxFilter(region, sums_of_squares, CV_32F, box, first_corner, false, cv::BORDER_CONSTANT);

    scores_.assign(static_cast<size_t>(edge) * static_cast<size_t>(edge), -1.0f);
    const int first_inside = std::max(left, r), last_inside = std::min(left + edge, image.width - r);
    for (int y = std::max(top, r); y < std::min(top + edge, image.height - r); ++y) {
      for (int x = first_inside; x < last_inside; x += kLanes) {
        const int at = (y - top) * width + (x - left);
        std::array<float, kLanes> products;
        multiply_some(region_.data() + at, width, template_.data(), edge_, products.data());
        for (int k = 0; k < std::min(kLanes, last_inside - x); ++k) {
          const float sum = sums_[static_cast<size_t>(at + k)];
          const float variance =
              sums_of_squares_[static_cast<size_t>(at + k)] - sum * sum / static_cast<float>(edge_ * edge_);
          if (variance < 1.0f) continue;
          scores_[static_cast<size_t>((y - top) * edge + x - left + k)] =
              products[static_cast<size_t>(k)] / std::sqrt(variance);
        }
      }
    }
  }

  bool search(int level, int reach, bool must_be_distinct, Eigen::Vector2d* pixel) {
    const Eigen::Vector2d center = to_level(*pixel, level);
    const int cx = static_cast<int>(std::lround(center.x()));
    const int cy = static_cast<int>(std::lround(center.y()));
    const int edge = 2 * reach + 1;
    with_level(b_, level, [&](const auto& image) { correlate(image, cx - reach, cy - reach, edge); });
    const auto best = std::max_element(scores_.begin(), scores_.end());
    constexpr float kMinCoarseCorrelation = 0.6f;
    if (*best < kMinCoarseCorrelation) return false;
    const int at = static_cast<int>(best - scores_.begin());
    const int bx = at % edge;
    const int by = at / edge;
    if (must_be_distinct && !is_distinct(edge, bx, by, *best)) return false;
    *pixel = from_level(Eigen::Vector2d(cx + bx - reach, cy + by - reach), level);
    return true;
  }

  bool is_distinct(int edge, int bx, int by, float best) const {
    constexpr int kPeakWidth = 2;
    for (int y = 0; y < edge; ++y) {
      for (int x = 0; x < edge; ++x) {
        if (std::abs(x - bx) <= kPeakWidth && std::abs(y - by) <= kPeakWidth) continue;
        if (scores_[static_cast<size_t>(y * edge + x)] > best - static_cast<float>(options_.min_distinction))
          return false;
      }
    }
    return true;
  }

  // Gauss-Newton on the difference of the normalised patches, as a shift in b.
  bool settle(const Eigen::Vector2d& pixel_a, const Eigen::Matrix2d& a_from_b, Eigen::Vector2d* pixel) {
    if (!make_template(pixel_a, a_from_b, 0)) return false;
    const Eigen::Vector2d start = *pixel;
    std::vector<float> values, slope_x, slope_y;
    for (int iteration = 0; iteration < 8; ++iteration) {
      if (!sample(*pixel, &values, &slope_x, &slope_y)) return false;
      const Eigen::Vector2d step = shift_of(&values, slope_x, slope_y);
      if (!step.allFinite()) return false;
      *pixel += step;
      if ((*pixel - start).norm() > 2.0) return false;
      if (step.norm() < 0.01) return correlation_ >= options_.min_correlation;
    }
    return false;
  }

  // The patch of b around a place, and its slopes; false where it reaches out of the image.
  bool sample(const Eigen::Vector2d& pixel, std::vector<float>* values, std::vector<float>* slope_x,
              std::vector<float>* slope_y) {
    const int r = options_.radius_px;
    const int width = edge_ + 2;
    region_.resize(static_cast<size_t>(width) * static_cast<size_t>(width));
    const auto at = [&](int x, int y) -> float& {
      return region_[static_cast<size_t>((y + r + 1) * width + x + r + 1)];
    };
    for (int y = -r - 1; y <= r + 1; ++y) {
      const int reach = std::abs(y) <= r ? r + 1 : r;  // the corners have no part in slopes
      for (int x = -reach; x <= reach; ++x) {
        if (!interpolate(b_.image, pixel.x() + x, pixel.y() + y, &at(x, y))) return false;
      }
    }
    values->clear();
    slope_x->clear();
    slope_y->clear();
    for (int y = -r; y <= r; ++y) {
      for (int x = -r; x <= r; ++x) {
        values->push_back(at(x, y));
        slope_x->push_back(0.5f * (at(x + 1, y) - at(x - 1, y)));
        slope_y->push_back(0.5f * (at(x, y + 1) - at(x, y - 1)));
      }
    }
    return true;
  }

  // Least squares of  template - normalised values  in the shift; sets correlation_ of the values as they are.
  Eigen::Vector2d shift_of(std::vector<float>* values, const std::vector<float>& slope_x,
                           const std::vector<float>& slope_y) {
    std::vector<float> normalised = *values;
    if (!normalise(&normalised)) return Eigen::Vector2d::Constant(NAN);
    float norm = 0.0f, mean = 0.0f;
    for (const float v : *values) mean += v;
    mean /= static_cast<float>(values->size());
    for (const float v : *values) norm += (v - mean) * (v - mean);
    const double inverse_norm = 1.0 / std::sqrt(norm);
    Eigen::Matrix2d h = Eigen::Matrix2d::Zero();
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    correlation_ = 0.0;
    for (size_t i = 0; i < normalised.size(); ++i) {
      const Eigen::Vector2d slope(slope_x[i] * inverse_norm, slope_y[i] * inverse_norm);
      h += slope * slope.transpose();
      g += slope * (template_[i] - normalised[i]);
      correlation_ += static_cast<double>(template_[i]) * normalised[i];
    }
    return h.inverse() * g;
  }

  const PatchView& a_;
  const PatchView& b_;
  const PatchMatchingOptions& options_;
  const int edge_;
  std::vector<float> template_;
  std::vector<float> region_, sums_, sums_of_squares_;
  std::vector<float> scores_;
  double correlation_ = 0.0;
};

}  // namespace

void PatchMatchingOptions::validate() const {
  check_option(max_patches >= 1, "max_patches", "[1, inf)", max_patches);
  check_option(min_distance_px > 0, "min_distance_px", "(0, inf)", min_distance_px);
  check_option(radius_px >= 2, "radius_px", "[2, inf)", radius_px);
  check_option(search_radius_px > 0, "search_radius_px", "(0, inf)", search_radius_px);
  check_option(min_correlation > 0 && min_correlation < 1, "min_correlation", "(0, 1)", min_correlation);
  check_option(min_distinction >= 0 && min_distinction < 1, "min_distinction", "[0, 1)", min_distinction);
}

PatchView prepare_patch_view(const GrayImage& image, const PlaneBuffer& planes, const RangeRaster& raster,
                             const PatchMatchingOptions& options) {
  PatchView view;
  if (!options.enabled) return view;
  view.image = image;
  view.planes = planes;
  view.raster.cell_px = raster.cell_px;
  view.raster.range = raster.range;
  view.halves.push_back(halve(image));
  while (view.halves.size() + 1 < kNumLevels) view.halves.push_back(halve(view.halves.back()));

  // Corners at half the size: cheaper, and what only the finest level shows would not be found from the coarsest.
  const Image<float>& half = view.halves.front();
  const cv::Mat gray(half.height, half.width, CV_32F, const_cast<float*>(half.pixels.data()));
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(gray, corners, 4 * options.max_patches, 0.005, 0.5 * options.min_distance_px, {}, 5);
  for (const cv::Point2f& corner : corners) {
    const Eigen::Vector2d pixel = from_level({corner.x, corner.y}, 1);
    const auto surface = surface_under(planes, raster, pixel, 2.0 * options.radius_px);
    if (!surface) continue;
    view.patches.push_back({pixel, *surface});
    if (static_cast<int>(view.patches.size()) >= options.max_patches) break;
  }
  return view;
}

double patch_overlap(const PatchView& a, const PatchView& b) {
  if (a.patches.empty()) return 0.0;
  const auto seen = std::count_if(a.patches.begin(), a.patches.end(),
                                  [&](const PatchView::Patch& patch) { return transfer(a, b, patch).has_value(); });
  return static_cast<double>(seen) / static_cast<double>(a.patches.size());
}

namespace {

// By how much the nearest matches are off from where they were expected: medians.
Eigen::Vector2d displacement_near(const Eigen::Vector2d& pixel_a, const std::vector<SurfaceMatch>& matches,
                                  const std::vector<Eigen::Vector2d>& displacements) {
  std::vector<std::pair<double, size_t>> near;
  for (size_t i = 0; i < matches.size(); ++i) near.emplace_back((matches[i].pixel_a - pixel_a).norm(), i);
  std::partial_sort(near.begin(), near.begin() + kGuides, near.end());
  Eigen::Vector2d median;
  for (int axis = 0; axis < 2; ++axis) {
    std::array<double, kGuides> values;
    for (size_t k = 0; k < kGuides; ++k) values[k] = displacements[near[k].second](axis);
    std::sort(values.begin(), values.end());
    median(axis) = 0.5 * (values[(kGuides - 1) / 2] + values[kGuides / 2]);
  }
  return median;
}

}  // namespace

std::vector<SurfaceMatch> match_patches(const PatchView& a, const PatchView& b, const PatchMatchingOptions& options) {
  Matcher matcher(a, b, options);
  std::vector<SurfaceMatch> matches;
  std::vector<Eigen::Vector2d> displacements;
  std::vector<std::pair<const PatchView::Patch*, Transfer>> lost;
  for (const PatchView::Patch& patch : a.patches) {
    const auto carried = transfer(a, b, patch);
    if (!carried) continue;
    if (const auto m = matcher.match(patch, *carried, options.search_radius_px)) {
      matches.push_back(*m);
      displacements.emplace_back(m->pixel_b - carried->pixel_b);
    } else {
      lost.emplace_back(&patch, *carried);
    }
  }
  if (matches.size() < kGuides || options.search_radius_px <= kGuidedRadiusPx) return matches;
  const std::vector<SurfaceMatch> guides = matches;
  for (auto& [patch, carried] : lost) {
    carried.pixel_b += displacement_near(patch->pixel, guides, displacements);
    if (const auto m = matcher.match(*patch, carried, kGuidedRadiusPx)) matches.push_back(*m);
  }
  return matches;
}

}  // namespace cpplus
