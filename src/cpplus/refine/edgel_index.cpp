#include "cpplus/refine/edgel_index.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cpplus {
namespace {

// Two passes of the chamfer distance transform (Borgefors 1986) with weights 1, sqrt 2: within 8 % of the Euclidean
// distance, which the search's tolerance swallows, at a fraction of its cost.
void chamfer(int width, int height, std::vector<float>* distance) {
  constexpr float kDiagonal = 1.41421356f;
  std::vector<float>& d = *distance;
  const auto at = [&](int x, int y) -> float& {
    return d[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float best = at(x, y);
      if (x > 0) best = std::min(best, at(x - 1, y) + 1.0f);
      if (y > 0) {
        best = std::min(best, at(x, y - 1) + 1.0f);
        if (x > 0) best = std::min(best, at(x - 1, y - 1) + kDiagonal);
        if (x + 1 < width) best = std::min(best, at(x + 1, y - 1) + kDiagonal);
      }
      at(x, y) = best;
    }
  }
  for (int y = height - 1; y >= 0; --y) {
    for (int x = width - 1; x >= 0; --x) {
      float best = at(x, y);
      if (x + 1 < width) best = std::min(best, at(x + 1, y) + 1.0f);
      if (y + 1 < height) {
        best = std::min(best, at(x, y + 1) + 1.0f);
        if (x > 0) best = std::min(best, at(x - 1, y + 1) + kDiagonal);
        if (x + 1 < width) best = std::min(best, at(x + 1, y + 1) + kDiagonal);
      }
      at(x, y) = best;
    }
  }
}

}  // namespace

EdgelIndex::EdgelIndex(const ImageEdges& edges)
    : edges_(edges), edgel_at_(static_cast<size_t>(edges.width) * static_cast<size_t>(edges.height), -1) {
  for (size_t i = 0; i < edges.edgels.size(); ++i) {
    const int x = static_cast<int>(std::lround(edges.edgels[i].pixel.x()));
    const int y = static_cast<int>(std::lround(edges.edgels[i].pixel.y()));
    if (x < 0 || y < 0 || x >= edges.width || y >= edges.height) continue;
    edgel_at_[static_cast<size_t>(y) * static_cast<size_t>(edges.width) + static_cast<size_t>(x)] =
        static_cast<int32_t>(i);
  }
}

int32_t EdgelIndex::agreeing_edgel(const Eigen::Vector2d& p, const Eigen::Vector2d& normal, double min_cos) const {
  const int x = static_cast<int>(std::lround(p.x()));
  const int y = static_cast<int>(std::lround(p.y()));
  if (x < 0 || y < 0 || x >= edges_.width || y >= edges_.height) return -1;
  const int32_t index = edgel_at_[static_cast<size_t>(y) * static_cast<size_t>(edges_.width) + static_cast<size_t>(x)];
  if (index < 0) return -1;
  const bool agrees = std::abs(edgel(static_cast<uint32_t>(index)).normal.cast<double>().dot(normal)) >= min_cos;
  return agrees ? index : -1;
}

std::optional<uint32_t> EdgelIndex::nearest_along(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal,
                                                  double radius_px, double min_cos) const {
  const Eigen::Vector2d tangent(-normal.y(), normal.x());
  const int steps = static_cast<int>(std::ceil(radius_px));
  std::optional<uint32_t> best;
  double best_distance = radius_px;
  // Outwards on both sides, one pixel a step, three pixels wide so that no chain slips through diagonally.
  for (int step = 0; step <= steps && step - 1.0 <= best_distance; ++step) {
    for (int sign = step == 0 ? 1 : -1; sign <= 1; sign += 2) {
      for (int side = -1; side <= 1; ++side) {
        const int32_t index = agreeing_edgel(pixel + sign * step * normal + side * tangent, normal, min_cos);
        if (index < 0) continue;
        const ImageEdgel& candidate = edgel(static_cast<uint32_t>(index));
        const double distance = std::abs(normal.dot(candidate.pixel.cast<double>() - pixel));
        if (distance < best_distance) {
          best_distance = distance;
          best = static_cast<uint32_t>(index);
        }
      }
    }
  }
  return best;
}

void EdgelIndex::all_along(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal, double radius_px,
                           double min_cos, std::vector<uint32_t>* found) const {
  const Eigen::Vector2d tangent(-normal.y(), normal.x());
  const int steps = static_cast<int>(std::ceil(radius_px));
  found->clear();
  for (int step = -steps; step <= steps; ++step) {
    for (int side = -1; side <= 1; ++side) {
      const int32_t index = agreeing_edgel(pixel + step * normal + side * tangent, normal, min_cos);
      if (index < 0) continue;
      // Neighbouring steps may round to the same pixel.
      const auto recent = found->end() - std::min<std::ptrdiff_t>(6, std::distance(found->begin(), found->end()));
      if (std::find(recent, found->end(), static_cast<uint32_t>(index)) != found->end()) continue;
      if (std::abs(normal.dot(edgel(static_cast<uint32_t>(index)).pixel.cast<double>() - pixel)) > radius_px) continue;
      found->push_back(static_cast<uint32_t>(index));
    }
  }
}

int DirectionalDistanceField::bin_of(const Eigen::Vector2d& normal) {
  double angle = std::atan2(normal.y(), normal.x());
  if (angle < 0) angle += std::numbers::pi;
  const int bin = static_cast<int>(angle / std::numbers::pi * kBins);
  return bin >= kBins ? 0 : bin;
}

DirectionalDistanceField::DirectionalDistanceField(const ImageEdges& edges, int cell_px, double max_distance_px)
    : width_((edges.width + cell_px - 1) / cell_px),
      height_((edges.height + cell_px - 1) / cell_px),
      inverse_cell_(1.0f / static_cast<float>(cell_px)),
      max_distance_(static_cast<float>(max_distance_px)) {
  const float far = static_cast<float>(max_distance_px / cell_px);
  for (std::vector<float>& field : fields_) {
    field.assign(static_cast<size_t>(width_) * static_cast<size_t>(height_), far);
  }
  for (const ImageEdgel& edgel : edges.edgels) {
    const int x = std::clamp(static_cast<int>((edgel.pixel.x() + 0.5f) * inverse_cell_), 0, width_ - 1);
    const int y = std::clamp(static_cast<int>((edgel.pixel.y() + 0.5f) * inverse_cell_), 0, height_ - 1);
    // Each edgel counts in its own bin and in the one next to it on the nearer side.
    double angle = std::atan2(edgel.normal.y(), edgel.normal.x());
    if (angle < 0) angle += std::numbers::pi;
    const double position = angle / std::numbers::pi * kBins;
    const int bin = static_cast<int>(position) % kBins;
    const int next = (position - std::floor(position) < 0.5 ? bin + kBins - 1 : bin + 1) % kBins;
    const size_t cell = static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
    fields_[static_cast<size_t>(bin)][cell] = 0.0f;
    fields_[static_cast<size_t>(next)][cell] = 0.0f;
  }
  for (std::vector<float>& field : fields_) {
    chamfer(width_, height_, &field);
    for (float& value : field) value *= static_cast<float>(cell_px);
  }
}

}  // namespace cpplus
