#include "cpplus/features/edge_chains.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "cpplus/core/for_each_set.h"
#include "cpplus/core/vector_clones.h"

namespace cpplus {
namespace {

// Sets of pixels that are joined where they are found to touch.
class Chains {
 public:
  // Adds a pixel to the chains of those of its neighbours that come before it (-1 = none). Of these the one above
  // touches all others, which are in its chain; the ones on the left touch each other.
  int32_t add(int32_t left, int32_t above_left, int32_t above, int32_t above_right, bool is_strong) {
    int32_t chain = above;
    if (chain < 0) {
      chain = left >= 0 ? left : above_left;
      if (chain < 0) {
        chain = above_right;
      } else if (above_right >= 0) {
        join(static_cast<uint32_t>(chain), static_cast<uint32_t>(above_right));
      }
    }
    if (chain < 0) chain = create();
    ++sizes_[static_cast<size_t>(chain)];
    is_strong_[static_cast<size_t>(chain)] |= static_cast<uint8_t>(is_strong);
    return chain;
  }

  // To be called when all pixels are there: from now on the parent of each chain is its first.
  void settle() {
    for (uint32_t chain = 0; chain < parents_.size(); ++chain) {
      const uint32_t first = parents_[chain] = parents_[parents_[chain]];
      if (first == chain) continue;
      sizes_[first] += sizes_[chain];
      is_strong_[first] |= is_strong_[chain];
    }
  }
  uint32_t first_of(uint32_t chain) const { return parents_[chain]; }
  bool is_strong(uint32_t first) const { return is_strong_[first] != 0; }
  std::vector<uint32_t> take_sizes() { return std::move(sizes_); }

 private:
  int32_t create() {
    parents_.push_back(static_cast<uint32_t>(parents_.size()));
    sizes_.push_back(0);
    is_strong_.push_back(0);
    return static_cast<int32_t>(parents_.back());
  }

  uint32_t root(uint32_t chain) {
    while (parents_[chain] != chain) chain = parents_[chain] = parents_[parents_[chain]];
    return chain;
  }

  // The older one becomes the parent: settle() then meets parents before their children.
  void join(uint32_t a, uint32_t b) {
    a = root(a);
    b = root(b);
    parents_[std::max(a, b)] = std::min(a, b);
  }

  std::vector<uint32_t> parents_;
  std::vector<uint32_t> sizes_;  // after settle() those of first chains hold for all that were joined
  std::vector<uint8_t> is_strong_;
};

CPPLUS_VECTOR_CLONES void square(const int16_t* __restrict dx, const int16_t* __restrict dy, int width,
                                 int32_t* __restrict out) {
  for (int x = 0; x < width; ++x) out[x] = int32_t{dx[x]} * dx[x] + int32_t{dy[x]} * dy[x];
}

// Squared magnitudes of three rows, with a zero at either end.
class MagnitudeRows {
 public:
  explicit MagnitudeRows(const ImageGradient& gradient) : gradient_(gradient) {
    for (std::vector<int32_t>& row : rows_) row.assign(static_cast<size_t>(gradient.width) + 2, 0);
    fill(0, &rows_[2]);
  }

  // Moves on by one row; the first call makes row 0 the middle one.
  void advance(int y) {
    std::rotate(rows_.begin(), rows_.begin() + 1, rows_.end());
    fill(y + 1, &rows_[2]);
  }

  // Element x of a row is pixel x; -1 and width are 0.
  const int32_t* above() const { return rows_[0].data() + 1; }
  const int32_t* middle() const { return rows_[1].data() + 1; }
  const int32_t* below() const { return rows_[2].data() + 1; }

 private:
  void fill(int y, std::vector<int32_t>* row) const {
    int32_t* out = row->data() + 1;
    if (y >= gradient_.height) {
      std::fill_n(out, gradient_.width, 0);
    } else {
      square(&gradient_.dx[gradient_.index(0, y)], &gradient_.dy[gradient_.index(0, y)], gradient_.width, out);
    }
  }

  const ImageGradient& gradient_;
  std::array<std::vector<int32_t>, 3> rows_;
};

// For each pixel of the middle row: is its gradient above the limit and larger than at the two neighbours nearest to
// its direction? Of two equal ones that touch along an axis the first counts. All pixels are asked, without branches,
// so that the loop becomes vector instructions.
CPPLUS_VECTOR_CLONES void flag_maxima(const MagnitudeRows& rows, const int16_t* dx, const int16_t* dy, int width,
                                      int32_t limit, uint8_t* flags) {
  constexpr int32_t kTan22 = 13573;  // of 22.5 degrees, in 1/32768
  const int32_t* above = rows.above();
  const int32_t* here = rows.middle();
  const int32_t* below = rows.below();
  for (int x = 0; x < width; ++x) {
    const int32_t m = here[x];
    const int32_t across = std::abs(int32_t{dx[x]});
    const int32_t down = std::abs(int32_t{dy[x]}) << 15;
    const int32_t low = across * kTan22;
    const bool is_horizontal = down < low;
    const bool is_vertical = down > low + (across << 16);
    const bool falls = (dx[x] ^ dy[x]) >= 0;
    const bool horizontal = (m > here[x - 1]) & (m >= here[x + 1]);
    const bool vertical = (m > above[x]) & (m >= below[x]);
    const bool falling = (m > above[x - 1]) & (m > below[x + 1]);
    const bool rising = (m > above[x + 1]) & (m > below[x - 1]);
    const bool diagonal = (falls & falling) | (!falls & rising);
    flags[x] = (m > limit) &
               ((is_horizontal & horizontal) | (is_vertical & vertical) | (!is_horizontal & !is_vertical & diagonal));
  }
}

// As thresholds are compared with whole squares.
int32_t whole_square(double value) {
  const double least = std::clamp(value, 0.0, 32767.0);
  return static_cast<int32_t>(std::floor(least * least));
}

}  // namespace

EdgeChains find_edge_chains(const ImageGradient& gradient, double weak, double strong) {
  const int32_t weak_square = whole_square(weak);
  const int32_t strong_square = whole_square(strong);
  std::vector<uint8_t> flags(static_cast<size_t>(gradient.width), 0);
  // Chain of each pixel of two rows, between a column of padding at either end.
  std::vector<int32_t> row_above(static_cast<size_t>(gradient.width) + 2, -1);
  std::vector<int32_t> row(row_above);
  std::vector<EdgePixel> candidates;
  Chains chains;
  MagnitudeRows magnitudes(gradient);
  for (int y = 0; y < gradient.height; ++y) {
    magnitudes.advance(y);
    std::fill(row.begin(), row.end(), -1);
    const size_t first = gradient.index(0, y);
    flag_maxima(magnitudes, &gradient.dx[first], &gradient.dy[first], gradient.width, weak_square, flags.data());
    for_each_set(flags.data(), flags.size(), [&](size_t x) {
      row[x + 1] =
          chains.add(row[x], row_above[x], row_above[x + 1], row_above[x + 2], magnitudes.middle()[x] > strong_square);
      candidates.push_back({static_cast<int>(x), y, static_cast<uint32_t>(row[x + 1])});
    });
    std::swap(row, row_above);
  }

  chains.settle();
  EdgeChains found;
  found.pixels.reserve(candidates.size());
  for (EdgePixel& pixel : candidates) {
    pixel.chain = chains.first_of(pixel.chain);
    if (chains.is_strong(pixel.chain)) found.pixels.push_back(pixel);
  }
  found.sizes = chains.take_sizes();
  return found;
}

}  // namespace cpplus
