#include "cpplus/visibility/outline_chains.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "cpplus/core/for_each_set.h"
#include "cpplus/core/vector_clones.h"

namespace cpplus {
namespace {

const std::array<Eigen::Vector2i, 4> kOutward = {Eigen::Vector2i(1, 0), Eigen::Vector2i(0, 1), Eigen::Vector2i(-1, 0),
                                                 Eigen::Vector2i(0, -1)};

// For the cells of a row with a surface, a bit a side where it does not go on in the next cell; `padded` has a cell
// more at either end, `above` and `below` are the rows beside.
CPPLUS_VECTOR_CLONES void flag_ends(const float* padded, const float* above, const float* below, int width,
                                    RangeJumpOptions options, uint8_t* sides) {
  const float* row = padded + 1;
  for (int x = 0; x < width; ++x) {
    const float near = row[x];
    const float limit = near + static_cast<float>(options.jump_at(static_cast<double>(near)));
    const auto ends = [limit](float next) { return !((next > 0.0f) & (next < limit)); };
    const int flags = ends(row[x + 1]) | ends(below[x]) << 1 | ends(row[x - 1]) << 2 | ends(above[x]) << 3;
    sides[x] = static_cast<uint8_t>(near == 0.0f ? 0 : flags);
  }
}

// Calls visit(x, y) for the cells that are not 0; most are.
template <typename Visit>
void for_each_cell_set(const Image<uint8_t>& cells, const Visit& visit) {
  for (int y = 0; y < cells.height; ++y) {
    for_each_set(&cells.at(0, y), static_cast<size_t>(cells.width), [&](size_t x) { visit(static_cast<int>(x), y); });
  }
}

class OutlineTracer {
 public:
  OutlineTracer(const RangeRaster& raster, const RangeJumpOptions& options)
      : raster_(raster), options_(options), sides_(raster.range.width, raster.range.height, 0) {
    flag_all_ends();
    for_each_cell_set(sides_, [&](int x, int y) {
      const float near = raster_.range.at(x, y);
      const float jump = static_cast<float>(options_.jump_at(static_cast<double>(near)));
      for (int side = 0; side < 4; ++side) {
        if (!has({x, y}, side) || is_step({x, y}, side, near, jump)) continue;
        sides_.at(x, y) = static_cast<uint8_t>(sides_.at(x, y) & ~(1 << side));
      }
    });
  }

  std::vector<std::vector<OutlineStep>> run() {
    std::vector<std::vector<OutlineStep>> chains;
    // First those that begin somewhere, then closed ones.
    for (const bool closed : {false, true}) {
      for_each_cell_set(sides_, [&](int x, int y) {
        for (int side = 0; side < 4; ++side) {
          if (has({x, y}, side) && (closed || !has_predecessor({x, y}, side))) chains.push_back(follow({x, y}, side));
        }
      });
    }
    return chains;
  }

 private:
  // Sides on which the surface does not go on in the next cell, as it does in most places.
  void flag_all_ends() {
    const RangeImage& range = raster_.range;
    const auto width = static_cast<size_t>(range.width);
    const std::vector<float> beyond(width, 0.0f);
    std::vector<float> padded(width + 2, 0.0f);
    for (int y = 0; y < range.height; ++y) {
      std::copy_n(&range.at(0, y), width, padded.begin() + 1);
      flag_ends(padded.data(), y > 0 ? &range.at(0, y - 1) : beyond.data(),
                y + 1 < range.height ? &range.at(0, y + 1) : beyond.data(), range.width, options_, &sides_.at(0, y));
    }
  }

  bool has(const Eigen::Vector2i& cell, int side) const {
    return sides_.contains(cell.x(), cell.y()) && (sides_.at(cell.x(), cell.y()) >> side & 1);
  }

  bool is_step(const Eigen::Vector2i& cell, int side, float near, float jump) const {
    const Eigen::Vector2i out = kOutward[static_cast<size_t>(side)];
    const int step = first_surface(cell, out);
    if (step == 0) return false;
    const float far = raster_.range_at(cell + step * out);
    if (far < near + jump || comes_back(cell + step * out, out, near + jump)) return false;
    // Along a line of the image 1 / range of a plane is linear. Twice the slope found: it is noisy.
    const float steps = static_cast<float>(std::min(step, 3));
    const float inner = raster_.range_at(cell - 2 * out);
    if (inner > 0.0f) {
      const float ahead = 1.0f / near + steps * std::min(0.0f, 1.0f / near - 1.0f / inner);
      if (ahead <= 0.0f || far < 1.0f / ahead + jump) return false;
    }
    const float outer = raster_.range_at(cell + (step + 2) * out);
    if (outer == 0.0f) return false;
    return 1.0f / (1.0f / far + steps * std::max(0.0f, 1.0f / far - 1.0f / outer)) > near + 0.5f * jump;
  }

  // How many cells outward the map has a surface again; 0 = none in reach. Between lies what is in the near surface's
  // shadow for the LiDAR but not for the camera, or the sky.
  int first_surface(const Eigen::Vector2i& cell, const Eigen::Vector2i& out) const {
    const int reach = 1 + static_cast<int>(options_.max_empty_px / raster_.cell_px);
    for (int k = 1; k <= reach; ++k) {
      if (!raster_.range.contains(cell.x() + k * out.x(), cell.y() + k * out.y())) return 0;
      if (raster_.range_at(cell + k * out) > 0.0f) return k;
    }
    return 0;
  }

  // Whether something nearer is met again soon: the same surface behind a gap between its points, or what casts the
  // shadow that the surface ends in.
  bool comes_back(const Eigen::Vector2i& far_cell, const Eigen::Vector2i& out, float least_range) const {
    const int reach = static_cast<int>(std::ceil(options_.min_far_px / raster_.cell_px));
    for (int k = 1; k < reach; ++k) {
      const float range = raster_.range_at(far_cell + k * out);
      if (range < least_range && (range > 0.0f || k <= 2)) return true;
    }
    return false;
  }

  using Place = std::pair<Eigen::Vector2i, int>;

  // Steps that begin where this one ends: round the same cell's corner, straight on, into the corner of the next cell.
  static std::array<Place, 3> successors(const Eigen::Vector2i& cell, int side) {
    const int next_side = (side + 1) % 4;
    const Eigen::Vector2i ahead = cell + kOutward[static_cast<size_t>(next_side)];
    return {Place{ahead, side}, Place{cell, next_side},
            Place{ahead + kOutward[static_cast<size_t>(side)], (side + 3) % 4}};
  }

  static std::array<Place, 3> predecessors(const Eigen::Vector2i& cell, int side) {
    const int last_side = (side + 3) % 4;
    const Eigen::Vector2i back = cell + kOutward[static_cast<size_t>(last_side)];
    return {Place{back, side}, Place{cell, last_side},
            Place{back + kOutward[static_cast<size_t>(side)], (side + 1) % 4}};
  }

  bool continues(const Eigen::Vector2i& from, const Place& to) const {
    if (!has(to.first, to.second)) return false;
    const float range = raster_.range_at(from);
    return std::abs(raster_.range_at(to.first) - range) < options_.jump_at(static_cast<double>(range));
  }

  bool has_predecessor(const Eigen::Vector2i& cell, int side) const {
    for (const Place& place : predecessors(cell, side)) {
      if (has(place.first, place.second) && continues(place.first, {cell, side})) return true;
    }
    for (const Place& place : across_gap(cell, side, -1)) {
      if (has(place.first, place.second) && direct_successor(place.first, side).second < 0 &&
          continues(place.first, {cell, side})) {
        return true;
      }
    }
    return false;
  }

  // The step that goes on at the nearest range. Side -1 where there is none.
  Place direct_successor(const Eigen::Vector2i& cell, int side) const {
    Place best = {cell, -1};
    float least = std::numeric_limits<float>::infinity();
    for (const Place& place : successors(cell, side)) {
      if (!continues(cell, place)) continue;
      const float difference = std::abs(raster_.range_at(place.first) - raster_.range_at(cell));
      if (difference >= least) continue;
      least = difference;
      best = place;
    }
    return best;
  }

  // Where a chain may go on after missing steps (before them with direction -1): single steps fail their test where
  // points are noisy.
  static std::array<Place, 6> across_gap(const Eigen::Vector2i& cell, int side, int direction) {
    const Eigen::Vector2i ahead = direction * kOutward[static_cast<size_t>((side + 1) % 4)];
    const Eigen::Vector2i out = kOutward[static_cast<size_t>(side)];
    std::array<Place, 6> places;
    size_t count = 0;
    for (const int skip : {2, 3}) {
      for (const int outward : {0, 1, -1}) places[count++] = {cell + skip * ahead + outward * out, side};
    }
    return places;
  }

  Place next_of(const Eigen::Vector2i& cell, int side) const {
    const Place direct = direct_successor(cell, side);
    if (direct.second >= 0) return direct;
    for (const Place& place : across_gap(cell, side, 1)) {
      if (continues(cell, place)) return place;
    }
    return direct;
  }

  std::vector<OutlineStep> follow(Eigen::Vector2i cell, int side) {
    std::vector<OutlineStep> chain;
    for (;;) {
      sides_.at(cell.x(), cell.y()) = static_cast<uint8_t>(sides_.at(cell.x(), cell.y()) & ~(1 << side));
      const Eigen::Vector2d out = kOutward[static_cast<size_t>(side)].cast<double>();
      const Eigen::Vector2d middle =
          raster_.corner_of(cell) + raster_.cell_px * (Eigen::Vector2d(0.5, 0.5) + 0.5 * out);
      chain.push_back({cell, side, middle, raster_.range_at(cell)});
      const Place next = next_of(cell, side);
      if (next.second < 0) return chain;
      std::tie(cell, side) = next;
    }
  }

  const RangeRaster& raster_;
  const RangeJumpOptions& options_;
  Image<uint8_t> sides_;  // bit per side: a step not yet in a chain
};

}  // namespace

void RangeJumpOptions::validate() const {
  check_option(min_jump_m > 0, "min_jump_m", "(0, inf)", min_jump_m);
  check_option(min_jump_ratio >= 0, "min_jump_ratio", "[0, inf)", min_jump_ratio);
  check_option(max_empty_px >= 0, "max_empty_px", "[0, inf)", max_empty_px);
  check_option(min_far_px > 0, "min_far_px", "(0, inf)", min_far_px);
}

std::vector<std::vector<OutlineStep>> trace_outlines(const RangeRaster& raster, const RangeJumpOptions& options) {
  return OutlineTracer(raster, options).run();
}

std::vector<ChainStretch> straight_stretches(const std::vector<OutlineStep>& chain, double tolerance_px) {
  std::vector<ChainStretch> straight;
  std::vector<ChainStretch> open;
  if (chain.size() >= 2) open.push_back({0, chain.size()});
  while (!open.empty()) {
    const ChainStretch stretch = open.back();
    open.pop_back();
    const Eigen::Vector2d start = chain[stretch.begin].pixel;
    const Eigen::Vector2d along = chain[stretch.end - 1].pixel - start;
    const double length = along.norm();
    double farthest = 0.0;
    size_t split = stretch.begin;
    for (size_t i = stretch.begin + 1; i + 1 < stretch.end; ++i) {
      const Eigen::Vector2d d = chain[i].pixel - start;
      // A loop has no line through its ends: it is cut where it is farthest from them.
      const double distance = length > 1e-9 ? std::abs(along.x() * d.y() - along.y() * d.x()) / length : d.norm();
      if (distance <= farthest) continue;
      farthest = distance;
      split = i;
    }
    if (farthest <= tolerance_px) {
      straight.push_back(stretch);
    } else {
      open.push_back({split, stretch.end});
      open.push_back({stretch.begin, split + 1});
    }
  }
  return straight;
}

}  // namespace cpplus
