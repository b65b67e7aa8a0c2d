#include "cpplus/render/surface_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "cpplus/cloud/node_range.h"
#include "cpplus/cloud/select_roots.h"
#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

constexpr int kBandRows = 32;  // rows of an image that one task draws
constexpr float kMinRangeM = 0.05f;
constexpr float kMinCosine = 0.08f;  // discs seen more from the side than this are not drawn
constexpr float kMinFragments = 2;

/// A point in the camera frame with the pixels that its disc may cover.
struct Disc {
  Eigen::Vector3f center;       // metres
  Eigen::Vector3f normal;       // unit or zero
  float radius = 0.0f;          // metres
  int first_x = 0, last_x = 0;  // columns; beyond the image where it wraps
  int first_y = 0, last_y = 0;
};

/// Finds the discs in view, root by root.
class DiscProjector {
 public:
  DiscProjector(const VoxelMap& map, const MapDiscs& discs, const Camera& camera, const Rigid3& camera_from_map,
                const SurfaceViewOptions& options)
      : map_(map),
        discs_(discs),
        camera_(camera),
        rotation_(camera_from_map.rotation.toRotationMatrix().cast<float>()),
        // float32 holds 60 m to micrometres: the large offsets cancel in double first.
        center_from_origin_((camera_center(camera_from_map) - map.origin()).cast<float>()),
        options_(options),
        wraps_(camera.model() == CameraModel::kEquirectangular) {}

  void add_root(uint32_t root, std::vector<Disc>* discs) const {
    const NodeRange leaves = leaves_of(map_, 0, root);
    for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
      const float spacing = discs_.leaf_spacing_m[leaf];
      if (!std::isfinite(spacing)) continue;
      const uint32_t points_end = map_.points_end(map_.leaf_layer(), leaf);
      for (uint32_t i = map_.points_begin(map_.leaf_layer(), leaf); i < points_end; ++i) {
        if (const auto disc = project(i, spacing)) discs->push_back(*disc);
      }
    }
  }

 private:
  std::optional<Disc> project(uint32_t point, float spacing) const {
    Disc disc;
    disc.center = rotation_ * (map_.positions()[point] - center_from_origin_);
    const float range = disc.center.norm();
    if (!(range > kMinRangeM && range < options_.max_distance_m)) return {};
    disc.normal = rotation_ * discs_.normals[point];
    const float cosine = disc.normal.dot(disc.center) / range;
    if (!disc.normal.isZero() && std::abs(cosine) < kMinCosine) return {};
    disc.radius = static_cast<float>(options_.disc_spacings) * spacing;

    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> d_pixel_d_point;
    if (!camera_.project(disc.center.cast<double>(), &pixel, &d_pixel_d_point)) return {};
    // A sphere around the point, to first order; never much more than the whole image.
    const Eigen::Array2d size(camera_.width(), camera_.height());
    const Eigen::Array2d half = (disc.radius * d_pixel_d_point.rowwise().norm().array()).max(0.5).min(0.5 * size - 0.5);
    const Eigen::Array2d first = (pixel.array() - half).ceil();
    const Eigen::Array2d last = (pixel.array() + half).floor();
    if (last.y() < 0 || first.y() > size.y() - 1) return {};
    if (!wraps_ && (last.x() < 0 || first.x() > size.x() - 1)) return {};
    disc.first_x = static_cast<int>(wraps_ ? first.x() : std::max(first.x(), 0.0));
    disc.last_x = static_cast<int>(wraps_ ? last.x() : std::min(last.x(), size.x() - 1));
    disc.first_y = static_cast<int>(std::max(first.y(), 0.0));
    disc.last_y = static_cast<int>(std::min(last.y(), size.y() - 1));
    return disc;
  }

  const VoxelMap& map_;
  const MapDiscs& discs_;
  const Camera& camera_;
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f center_from_origin_;
  const SurfaceViewOptions& options_;
  bool wraps_;
};

/// Where a ray meets a disc.
struct Fragment {
  float range = 0.0f;
  float weight = 0.0f;
  float cosine = 1.0f;
  Eigen::Vector3f offset;  // from the point to where the ray meets the disc's plane, metres
};

std::optional<Fragment> meet(const Disc& disc, const Eigen::Vector3f& bearing) {
  Fragment fragment;
  if (disc.normal.isZero()) {
    fragment.range = disc.center.dot(bearing);
  } else {
    const float slope = disc.normal.dot(bearing);
    fragment.cosine = std::abs(slope);
    if (fragment.cosine < kMinCosine) return {};
    fragment.range = disc.normal.dot(disc.center) / slope;
  }
  if (!(fragment.range > kMinRangeM)) return {};
  fragment.offset = fragment.range * bearing - disc.center;
  const float share = fragment.offset.squaredNorm() / (disc.radius * disc.radius);
  if (!(share < 1.0f)) return {};
  fragment.weight = 1.0f - share;
  return fragment;
}

/// Draws the discs into some rows of the view.
class Band {
 public:
  Band(const Image<Eigen::Vector3f>& bearings, int first_row, int end_row, const SurfaceViewOptions& options)
      : bearings_(bearings),
        options_(options),
        first_row_(first_row),
        end_row_(end_row),
        nearest_(bearings.width, end_row - first_row, std::numeric_limits<float>::infinity()),
        sums_(bearings.width, end_row - first_row) {}

  void draw(const std::vector<std::vector<Disc>>& discs_of_roots) {
    for_each_fragment(discs_of_roots, [&](const Disc&, const Fragment& fragment, int x, int row) {
      float& nearest = nearest_.at(x, row);
      nearest = std::min(nearest, fragment.range);
    });
    for_each_fragment(discs_of_roots, [&](const Disc& disc, const Fragment& fragment, int x, int row) {
      const float behind = fragment.range - nearest_.at(x, row);
      if (behind * fragment.cosine > options_.thickness_m) return;
      Sum& sum = sums_.at(x, row);
      sum.weight += fragment.weight;
      sum.range += fragment.weight * fragment.range;
      sum.share += fragment.weight * fragment.offset / disc.radius;
      sum.count += 1.0f;
      const float towards_camera = disc.normal.dot(bearings_.at(x, row + first_row_)) < 0.0f ? 1.0f : -1.0f;
      sum.normal += towards_camera * fragment.weight * disc.normal;
    });
  }

  void write(SurfaceView* view) const {
    for (int row = 0; row < end_row_ - first_row_; ++row) {
      for (int x = 0; x < sums_.width; ++x) {
        const Sum& sum = sums_.at(x, row);
        if (sum.count < kMinFragments || sum.share.norm() > options_.max_lopsidedness * sum.weight) continue;
        view->range.at(x, row + first_row_) = sum.range / sum.weight;
        const float length = sum.normal.norm();
        if (length > 0.0f) view->normals.at(x, row + first_row_) = sum.normal / length;
      }
    }
  }

 private:
  struct Sum {
    float weight = 0.0f;
    float range = 0.0f;
    float count = 0.0f;
    Eigen::Vector3f share = Eigen::Vector3f::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  };

  /// Calls draw_fragment(disc, fragment, column, row of the band), always in the same order.
  template <typename Draw>
  void for_each_fragment(const std::vector<std::vector<Disc>>& discs_of_roots, const Draw& draw_fragment) const {
    const int width = bearings_.width;
    for (const std::vector<Disc>& discs : discs_of_roots) {
      for (const Disc& disc : discs) {
        const int last_y = std::min(disc.last_y, end_row_ - 1);
        for (int y = std::max(disc.first_y, first_row_); y <= last_y; ++y) {
          for (int column = disc.first_x; column <= disc.last_x; ++column) {
            const int x = column < 0 ? column + width : column >= width ? column - width : column;
            const Eigen::Vector3f& bearing = bearings_.at(x, y);
            if (bearing.isZero()) continue;
            if (const auto fragment = meet(disc, bearing)) draw_fragment(disc, *fragment, x, y - first_row_);
          }
        }
      }
    }
  }

  const Image<Eigen::Vector3f>& bearings_;
  const SurfaceViewOptions& options_;
  int first_row_;
  int end_row_;
  RangeImage nearest_;
  Image<Sum> sums_;
};

}  // namespace

void SurfaceViewOptions::validate() const {
  check_option(max_distance_m > 0, "max_distance_m", "(0, inf)", max_distance_m);
  check_option(disc_spacings > 0 && disc_spacings <= 10, "disc_spacings", "(0, 10]", disc_spacings);
  check_option(thickness_m > 0, "thickness_m", "(0, inf)", thickness_m);
  check_option(max_lopsidedness > 0 && max_lopsidedness <= 1, "max_lopsidedness", "(0, 1]", max_lopsidedness);
}

Image<Eigen::Vector3f> pixel_bearings(const Camera& camera) {
  Image<Eigen::Vector3f> bearings(camera.width(), camera.height(), Eigen::Vector3f::Zero());
  parallel_for_chunks(static_cast<size_t>(camera.height()), 16, [&](size_t begin, size_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < camera.width(); ++x) {
        if (const auto bearing = camera.unproject(Eigen::Vector2d(x, y))) bearings.at(x, y) = bearing->cast<float>();
      }
    }
  });
  return bearings;
}

SurfaceView render_surface(const VoxelMap& map, const MapDiscs& discs, const Camera& camera,
                           const Image<Eigen::Vector3f>& bearings, const Rigid3& camera_from_map,
                           const SurfaceViewOptions& options) {
  options.validate();
  const std::vector<uint32_t> roots = select_roots(map, camera, camera_from_map, options.max_distance_m);
  std::vector<std::vector<Disc>> discs_of_roots(roots.size());
  const DiscProjector projector(map, discs, camera, camera_from_map, options);
  parallel_for_each(roots.size(), [&](size_t k) { projector.add_root(roots[k], &discs_of_roots[k]); });

  SurfaceView view;
  view.range = RangeImage(camera.width(), camera.height(), 0.0f);
  view.normals = Image<Eigen::Vector3f>(camera.width(), camera.height(), Eigen::Vector3f::Zero());
  const size_t num_bands = static_cast<size_t>((camera.height() + kBandRows - 1) / kBandRows);
  parallel_for_each(num_bands, [&](size_t b) {
    const int first_row = static_cast<int>(b) * kBandRows;
    Band band(bearings, first_row, std::min(first_row + kBandRows, camera.height()), options);
    band.draw(discs_of_roots);
    band.write(&view);
  });
  return view;
}

}  // namespace cpplus
