#pragma once

#include <bit>
#include <cstdint>
#include <limits>

#include "cpplus/core/image.h"

namespace cpplus {

/// A range and what was seen there in one number, of which the nearer one is the smaller: numbers above zero are
/// ordered as their bits are. A double, because vector instructions take the smaller of two of these.
using RangeKey = double;

/// Behind everything.
inline constexpr RangeKey kNoRangeKey = std::numeric_limits<RangeKey>::infinity();

/// range_m > 0.
inline RangeKey range_key(float range_m, uint32_t what) {
  return std::bit_cast<RangeKey>(uint64_t{std::bit_cast<uint32_t>(range_m)} << 32 | what);
}
inline float range_of(RangeKey key) {
  return std::bit_cast<float>(static_cast<uint32_t>(std::bit_cast<uint64_t>(key) >> 32));
}
inline uint32_t what_of(RangeKey key) { return static_cast<uint32_t>(std::bit_cast<uint64_t>(key)); }

/// Puts the key into the cells of columns first_x ... last_x and rows first_y ... last_y of the image that hold none
/// that is nearer. The columns must lie in the image, rows are cut off.
void draw_rectangle(int first_x, int last_x, int first_y, int last_y, RangeKey key, Image<RangeKey>* keys);

/// Lets each key take the cells around it, the nearest winning.
void spread_by_one(Image<RangeKey>* keys);

/// Takes the nearer key of each cell into `keys`; images of one size.
void take_nearer(const Image<RangeKey>& other, Image<RangeKey>* keys);

}  // namespace cpplus
