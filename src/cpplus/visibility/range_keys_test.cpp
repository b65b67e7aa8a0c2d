#include "cpplus/visibility/range_keys.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

Image<RangeKey> some_keys(int width, int height, uint64_t seed) {
  Random random(seed);
  Image<RangeKey> keys(width, height, kNoRangeKey);
  for (RangeKey& key : keys.pixels) {
    if (random.below(3) == 0) key = range_key(0.1f + static_cast<float>(random.below(1000)), 7);
  }
  return keys;
}

TEST(RangeKeys, HoldBothAndAreOrderedByRange) {
  const RangeKey near = range_key(1.25f, 0xffffffffu);
  const RangeKey far = range_key(1.2500001f, 0);
  EXPECT_EQ(range_of(near), 1.25f);
  EXPECT_EQ(what_of(near), 0xffffffffu);
  EXPECT_LT(near, far);
  EXPECT_LT(far, kNoRangeKey);
  EXPECT_LT(range_key(1e-6f, 3), range_key(1e30f, 0));
}

TEST(RangeKeys, ARectangleIsCutOffAndNeverHidesWhatIsNearer) {
  Image<RangeKey> keys(5, 3, kNoRangeKey);
  keys.at(1, 0) = range_key(2.0f, 1);
  keys.at(2, 0) = range_key(9.0f, 2);
  draw_rectangle(1, 3, -4, 1, range_key(5.0f, 3), &keys);
  EXPECT_EQ(what_of(keys.at(1, 0)), 1u);
  EXPECT_EQ(what_of(keys.at(2, 0)), 3u);
  EXPECT_EQ(std::count(keys.pixels.begin(), keys.pixels.end(), range_key(5.0f, 3)), 5);
  EXPECT_EQ(keys.at(0, 0), kNoRangeKey);
  EXPECT_EQ(keys.at(4, 1), kNoRangeKey);
  EXPECT_EQ(keys.at(2, 2), kNoRangeKey);
}

TEST(RangeKeys, SpreadToTheCellsAround) {
  for (const int width : {1, 2, 3, 17}) {
    for (const int height : {1, 2, 9}) {
      const Image<RangeKey> before = some_keys(width, height, 5);
      Image<RangeKey> after = before;
      spread_by_one(&after);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          RangeKey nearest = kNoRangeKey;
          for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v) {
            for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u) {
              nearest = std::min(nearest, before.at(u, v));
            }
          }
          ASSERT_EQ(after.at(x, y), nearest) << x << " " << y << " of " << width << " x " << height;
        }
      }
    }
  }
}

TEST(RangeKeys, TheNearerOfTwoImages) {
  Image<RangeKey> keys = some_keys(13, 5, 1);
  const Image<RangeKey> before = keys;
  const Image<RangeKey> other = some_keys(13, 5, 2);
  take_nearer(other, &keys);
  for (size_t i = 0; i < keys.pixels.size(); ++i)
    EXPECT_EQ(keys.pixels[i], std::min(before.pixels[i], other.pixels[i]));
}

}  // namespace
}  // namespace cpplus
