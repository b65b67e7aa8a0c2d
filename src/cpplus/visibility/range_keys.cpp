#include "cpplus/visibility/range_keys.h"

#include <algorithm>
#include <array>
#include <vector>

#include "cpplus/core/vector_clones.h"

namespace cpplus {
namespace {

CPPLUS_VECTOR_CLONES void take_nearer(const RangeKey* from, size_t count, RangeKey* to) {
  for (size_t i = 0; i < count; ++i) to[i] = from[i] < to[i] ? from[i] : to[i];
}

// The nearest of each three keys abreast.
CPPLUS_VECTOR_CLONES void nearest_of_three(const RangeKey* in, size_t count, RangeKey* out) {
  if (count < 3) {
    std::fill_n(out, count, *std::min_element(in, in + count));
    return;
  }
  out[0] = std::min(in[0], in[1]);
  for (size_t i = 1; i + 1 < count; ++i) {
    const RangeKey beside = in[i - 1] < in[i + 1] ? in[i - 1] : in[i + 1];
    out[i] = beside < in[i] ? beside : in[i];
  }
  out[count - 1] = std::min(in[count - 2], in[count - 1]);
}

}  // namespace

void draw_rectangle(int first_x, int last_x, int first_y, int last_y, RangeKey key, Image<RangeKey>* keys) {
  first_y = std::max(0, first_y);
  last_y = std::min(keys->height - 1, last_y);
  if (first_y > last_y) return;
  // Most rectangles are some cells wide: two cells are a vector that every processor has.
  const std::ptrdiff_t width = last_x - first_x + 1;
  RangeKey* row = &keys->at(first_x, first_y);
  for (int y = first_y; y <= last_y; ++y, row += keys->width) {
    std::ptrdiff_t x = 0;
    for (; x + 2 <= width; x += 2) {
      const RangeKey a = key < row[x] ? key : row[x];
      const RangeKey b = key < row[x + 1] ? key : row[x + 1];
      row[x] = a;
      row[x + 1] = b;
    }
    if (x < width) row[x] = key < row[x] ? key : row[x];
  }
}

void spread_by_one(Image<RangeKey>* keys) {
  if (keys->pixels.empty()) return;
  const auto width = static_cast<size_t>(keys->width);
  std::array<std::vector<RangeKey>, 3> rows;  // of the image before, each spread along itself: above, here, below
  for (std::vector<RangeKey>& row : rows) row.assign(width, kNoRangeKey);
  nearest_of_three(&keys->at(0, 0), width, rows[2].data());
  for (int y = 0; y < keys->height; ++y) {
    std::rotate(rows.begin(), rows.begin() + 1, rows.end());
    if (y + 1 < keys->height) {
      nearest_of_three(&keys->at(0, y + 1), width, rows[2].data());
    } else {
      std::fill(rows[2].begin(), rows[2].end(), kNoRangeKey);
    }
    RangeKey* here = &keys->at(0, y);
    for (const std::vector<RangeKey>& row : rows) take_nearer(row.data(), width, here);
  }
}

void take_nearer(const Image<RangeKey>& other, Image<RangeKey>* keys) {
  take_nearer(other.pixels.data(), other.pixels.size(), keys->pixels.data());
}

}  // namespace cpplus
