#include "cpplus/refine/edgel_index.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cpplus/core/vector_clones.h"

namespace cpplus {
namespace {

// A distance that is far, in the field's units: any two add up without overflow.
constexpr int kFar = 16000;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;

// Which sixteenth of half a turn a direction lies in, the same for the opposite one, told without its angle and without
// branches, which no processor could foresee.
template <typename Scalar>
inline int sixteenth_of(Scalar x, Scalar y) {
  // Tangents of 11.25, 22.5 and 33.75 degrees.
  constexpr std::array<Scalar, 3> kTangents = {Scalar(0.19891236737965800), Scalar(0.41421356237309503),
                                               Scalar(0.66817863791929898)};
  const bool is_opposite = (y < 0) | ((y == 0) & (x < 0));
  const Scalar along = is_opposite ? -x : x;
  const Scalar across = x < 0 ? -x : x;
  const Scalar up = y < 0 ? -y : y;
  int part = up >= across;
  for (const Scalar tangent : kTangents) part += (up >= tangent * across) + (across <= tangent * up);
  return along >= 0 ? part : 15 - part;
}

// Adds to each bits the eighth of half a turn that its normal, turned, lies in.
CPPLUS_VECTOR_CLONES void add_turned_directions(const float* __restrict x, const float* __restrict y, size_t count,
                                                float cosine, float sine, int32_t* __restrict bits) {
  for (size_t i = 0; i < count; ++i) {
    bits[i] |= 1 << (sixteenth_of(cosine * x[i] - sine * y[i], sine * x[i] + cosine * y[i]) / 2);
  }
}

// Turns (cosine and sine) by angles from -max_angle_deg to max_angle_deg, with some room for rounding, none farther
// from the next than an eighth of half a turn.
std::vector<Eigen::Vector2d> turns_up_to(double max_angle_deg) {
  constexpr double kEighthDeg = 22.5;
  constexpr double kRoomDeg = 0.1;
  const double widest = max_angle_deg + kRoomDeg;
  const int steps = static_cast<int>(std::ceil(widest / kEighthDeg));
  std::vector<Eigen::Vector2d> turns;
  for (int k = -steps; k <= steps; ++k) {
    const double angle = widest * k / steps * kRadPerDeg;
    turns.emplace_back(std::cos(angle), std::sin(angle));
  }
  return turns;
}

// Of each edgel the bits of all normals that agree with it.
std::vector<int32_t> agreeing_directions(const std::vector<ImageEdgel>& edgels, double max_angle_deg) {
  std::vector<float> x, y;
  x.reserve(edgels.size());
  y.reserve(edgels.size());
  for (const ImageEdgel& edgel : edgels) {
    x.push_back(edgel.normal.x());
    y.push_back(edgel.normal.y());
  }
  std::vector<int32_t> bits(edgels.size(), 0);
  for (const Eigen::Vector2d& turn : turns_up_to(max_angle_deg)) {
    add_turned_directions(x.data(), y.data(), x.size(), static_cast<float>(turn.x()), static_cast<float>(turn.y()),
                          bits.data());
  }
  return bits;
}

CPPLUS_VECTOR_CLONES void join_three(const uint8_t* __restrict a, const uint8_t* __restrict b,
                                     const uint8_t* __restrict c, size_t count, uint8_t* __restrict out) {
  for (size_t i = 0; i < count; ++i) out[i] = a[i] | b[i] | c[i];
}

// Gives each pixel the bits of its eight neighbours too.
void join_neighbors(int width, int height, std::vector<uint8_t>* pixels) {
  const auto columns = static_cast<size_t>(width);
  std::vector<uint8_t> padded(columns + 2, 0);
  std::array<std::vector<uint8_t>, 3> joined;  // rows joined along themselves, by turns; nothing beyond the image
  for (std::vector<uint8_t>& row : joined) row.assign(columns, 0);
  const auto join_along = [&](int y) {
    std::vector<uint8_t>& out = joined[static_cast<size_t>(y) % 3];
    if (y == height) return out.assign(columns, 0);
    std::copy_n(pixels->begin() + static_cast<std::ptrdiff_t>(y) * width, columns, padded.begin() + 1);
    join_three(padded.data(), padded.data() + 1, padded.data() + 2, columns, out.data());
  };
  if (height > 0) join_along(0);
  for (int y = 0; y < height; ++y) {
    join_along(y + 1);
    join_three(joined[0].data(), joined[1].data(), joined[2].data(), columns,
               pixels->data() + static_cast<size_t>(y) * columns);
  }
}

}  // namespace

EdgelIndex::EdgelIndex(const ImageEdges& edges, double max_angle_deg)
    : edges_(edges),
      min_cos_(std::cos(max_angle_deg * kRadPerDeg)),
      directions_near_(static_cast<size_t>(edges.width) * static_cast<size_t>(edges.height), 0) {
  occupied_.assign(directions_near_.size() / 64 + 1, 0);
  const std::vector<int32_t> agreeing = agreeing_directions(edges.edgels, max_angle_deg);
  std::vector<size_t> pixel_of(edges.edgels.size(), directions_near_.size());
  for (size_t i = 0; i < edges.edgels.size(); ++i) {
    const Eigen::Vector2f at = edges.edgels[i].pixel.array() + 0.5f;
    const Eigen::Array2f size(static_cast<float>(edges.width), static_cast<float>(edges.height));
    if (!(at.array() >= 0.0f && at.array() < size).all()) continue;
    const int x = static_cast<int>(at.x());
    const int y = static_cast<int>(at.y());
    pixel_of[i] = index_of(x, y);
    occupied_[pixel_of[i] / 64] |= uint64_t{1} << (pixel_of[i] % 64);
    directions_near_[pixel_of[i]] |= static_cast<uint8_t>(agreeing[i]);
  }
  join_neighbors(edges.width, edges.height, &directions_near_);
  uint32_t count = 0;
  for (const uint64_t word : occupied_) {
    num_before_.push_back(count);
    count += static_cast<uint32_t>(std::popcount(word));
  }
  by_pixel_.resize(count);
  for (size_t i = 0; i < pixel_of.size(); ++i) {
    if (pixel_of[i] < directions_near_.size()) by_pixel_[place_of(pixel_of[i])] = static_cast<uint32_t>(i);
  }
}

uint8_t EdgelIndex::direction_of(const Eigen::Vector2d& normal) {
  return static_cast<uint8_t>(1 << (sixteenth_of(normal.x(), normal.y()) / 2));
}

template <typename Visit>
void EdgelIndex::for_each_abreast(const Eigen::Vector2d& place, const Eigen::Vector2d& normal, uint8_t direction,
                                  const Visit& visit) const {
  // No pixel abreast lies farther from that of the place than one row and column.
  if (place.x() >= 0 && place.y() >= 0 && place.x() < edges_.width - 1 && place.y() < edges_.height - 1 &&
      !(directions_near_[index_of(static_cast<int>(place.x() + 0.5), static_cast<int>(place.y() + 0.5))] & direction)) {
    return;
  }
  for (int side = -1; side <= 1; ++side) {
    // Rounded to the nearest pixel; compared before the conversion, which far numbers would overflow.
    const double x = place.x() - side * normal.y() + 0.5;
    const double y = place.y() + side * normal.x() + 0.5;
    if (!(x >= 0 && y >= 0 && x < edges_.width && y < edges_.height)) continue;
    const size_t at = index_of(static_cast<int>(x), static_cast<int>(y));
    if (!is_occupied(at)) continue;
    const uint32_t index = by_pixel_[place_of(at)];
    if (std::abs(edgel(index).normal.cast<double>().dot(normal)) >= min_cos_) visit(index);
  }
}

namespace {

// Pixels along a line, one a step, as indices into an image: in fixed point.
class PixelLine {
 public:
  PixelLine(const Eigen::Vector2d& pixel, const Eigen::Vector2d& step, int width)
      : x_(fixed(pixel.x() + 0.5)),
        y_(fixed(pixel.y() + 0.5)),
        dx_(fixed(step.x())),
        dy_(fixed(step.y())),
        width_(width) {}

  size_t pixel_at(int step) const {
    return static_cast<size_t>(((y_ + step * dy_) >> kBits) * width_ + ((x_ + step * dx_) >> kBits));
  }

 private:
  static constexpr int kBits = 20;
  static int64_t fixed(double value) { return static_cast<int64_t>(value * (1 << kBits)); }

  int64_t x_, y_, dx_, dy_;
  int64_t width_;
};

}  // namespace

std::optional<uint32_t> EdgelIndex::nearest_along(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal,
                                                  double radius_px) const {
  const int steps = static_cast<int>(std::ceil(radius_px));
  const uint8_t direction = direction_of(normal);
  std::optional<uint32_t> best;
  double best_distance = radius_px;
  const auto consider = [&](uint32_t index) {
    const double distance = std::abs(normal.dot(edgel(index).pixel.cast<double>() - pixel));
    if (distance >= best_distance) return;
    best_distance = distance;
    best = index;
  };
  const bool inside = is_inside(pixel, steps + 2.0);
  const PixelLine line(inside ? pixel : Eigen::Vector2d(0, 0), normal, edges_.width);
  const auto look_at = [&](int step) {
    // Mostly there is nothing, which whole numbers tell soonest.
    if (inside && !(directions_near_[line.pixel_at(step)] & direction)) return;
    for_each_abreast(pixel + step * normal, normal, direction, consider);
  };
  // Outwards on both sides, one pixel a step, three pixels wide so that no chain slips through diagonally.
  for (int step = 0; step <= steps && step - 1.0 <= best_distance; ++step) {
    if (step > 0) look_at(-step);
    look_at(step);
  }
  return best;
}

void EdgelIndex::all_along(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal, double radius_px,
                           std::vector<uint32_t>* found) const {
  const int steps = static_cast<int>(std::ceil(radius_px));
  const uint8_t direction = direction_of(normal);
  found->clear();
  for (int step = -steps; step <= steps; ++step) {
    for_each_abreast(pixel + step * normal, normal, direction, [&](uint32_t index) {
      if (std::find(found->begin(), found->end(), index) != found->end()) return;
      if (std::abs(normal.dot(edgel(index).pixel.cast<double>() - pixel)) > radius_px) return;
      found->push_back(index);
    });
  }
}

int DirectionalDistanceField::bin_of(const Eigen::Vector2d& normal) {
  static_assert(kBins == 8);
  return sixteenth_of(normal.x(), normal.y()) / 2;
}

DirectionalDistanceField::DirectionalDistanceField(const ImageEdges& edges, int cell_px, double max_distance_px)
    : stride_((edges.width + cell_px - 1) / cell_px + 2),
      rows_((edges.height + cell_px - 1) / cell_px + 2),
      inverse_cell_(1.0f / static_cast<float>(cell_px)),
      last_column_(static_cast<float>(stride_) - 0.5f),
      last_row_(static_cast<float>(rows_) - 0.5f),
      max_distance_(static_cast<float>(max_distance_px)),
      unit_px_(max_distance_ / kFar),
      field_(static_cast<size_t>(stride_ * rows_) * kBins, kFar) {
  if (edges.width <= 0 || edges.height <= 0) return;
  for (const ImageEdgel& edgel : edges.edgels) {
    const int column = std::clamp(static_cast<int>((edgel.pixel.x() + 0.5f) * inverse_cell_) + 1, 1, stride_ - 2);
    const int row = std::clamp(static_cast<int>((edgel.pixel.y() + 0.5f) * inverse_cell_) + 1, 1, rows_ - 2);
    // Each edgel counts in its own bin and in the one next to it on the nearer side.
    const int sixteenth = sixteenth_of(edgel.normal.x(), edgel.normal.y());
    const int bin = sixteenth / 2;
    const int next = (sixteenth % 2 == 0 ? bin + kBins - 1 : bin + 1) % kBins;
    cell(column, row)[bin] = 0;
    cell(column, row)[next] = 0;
  }
  const double cell_units = cell_px * kFar / max_distance_px;
  const auto step = [&](double cells) { return static_cast<int16_t>(std::min<double>(kFar, cells * cell_units)); };
  spread(step(1.0), step(std::numbers::sqrt2));
}

// Weights 1, sqrt 2 (Borgefors 1986): within 8 % of the Euclidean distance, which the search's tolerance swallows, at a
// fraction of its cost.
void DirectionalDistanceField::spread(int16_t straight, int16_t diagonal) {
  const auto relax = [](int16_t* to, const int16_t* from, int16_t step) {
    for (int bin = 0; bin < kBins; ++bin) to[bin] = std::min(to[bin], static_cast<int16_t>(from[bin] + step));
  };
  const int row_step = stride_ * kBins;
  const auto pass = [&](int16_t* here, int forward) {
    Distances best;
    std::copy(here, here + kBins, best.begin());
    relax(best.data(), here - forward * kBins, straight);
    relax(best.data(), here - forward * row_step, straight);
    relax(best.data(), here - forward * (row_step + kBins), diagonal);
    relax(best.data(), here - forward * (row_step - kBins), diagonal);
    std::copy(best.begin(), best.end(), here);
  };
  for (int row = 1; row + 1 < rows_; ++row) {
    for (int column = 1; column + 1 < stride_; ++column) pass(cell(column, row), 1);
  }
  for (int row = rows_ - 2; row > 0; --row) {
    for (int column = stride_ - 2; column > 0; --column) pass(cell(column, row), -1);
  }
}

}  // namespace cpplus
