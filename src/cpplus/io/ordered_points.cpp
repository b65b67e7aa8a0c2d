#include "cpplus/io/ordered_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/core/slot_pipeline.h"

namespace cpplus {
namespace {

/// Points that are put in order at a time, some 20 MB of them.
constexpr size_t kBlockPoints = size_t{1} << 18;
/// What points wait in for their block to be written, in all.
constexpr size_t kBufferBytes = size_t{64} << 20;
/// Blocks on their way from the disk to the visitor.
constexpr size_t kSlots = 3;

struct Slot {
  size_t number = 0;  // of the block
  PointBucket points;
  PointCloud block;
};

std::vector<uint64_t> block_sizes(size_t num_points) {
  std::vector<uint64_t> sizes(num_points / kBlockPoints, kBlockPoints);
  if (num_points % kBlockPoints != 0) sizes.push_back(num_points % kBlockPoints);
  return sizes;
}

}  // namespace

OrderedPoints::OrderedPoints(const std::string& map, const std::string& target, size_t num_points,
                             const PointAttributes& attributes)
    : map_(map),
      num_points_(num_points),
      num_blocks_(block_sizes(num_points).size()),
      attributes_(attributes),
      buckets_(std::make_unique<ScratchFile>(target), block_sizes(num_points), attributes, kBufferBytes) {}

void OrderedPoints::add(const PointCloud& points, std::span<const uint32_t> indices) {
  for (size_t i = 0; i < indices.size(); ++i) {
    const uint32_t index = indices[i];
    if (index >= num_points_ || !buckets_.add(index / kBlockPoints, points, i, index)) fail();
  }
  buckets_.write(buckets_.take_full());
}

CloudStream OrderedPoints::finish(const Eigen::Vector3d& origin, const std::optional<LasFrame>& las_frame) {
  if (!buckets_.finish()) fail();
  return {num_points_, [this, origin, las_frame](const auto& visit) {
            std::array<Slot, kSlots> slots;
            size_t next = 0;
            run_slot_pipeline(kSlots, {[&](size_t slot) {
                                         if (next == num_blocks_) return false;
                                         slots[slot].number = next++;
                                         buckets_.read(slots[slot].number, &slots[slot].points);
                                         return true;
                                       },
                                       [&](size_t slot) {
                                         PointCloud& block = slots[slot].block;
                                         block = in_order(slots[slot].number, slots[slot].points);
                                         block.origin = origin;
                                         block.las_frame = las_frame;
                                       },
                                       [&](size_t slot) { visit(slots[slot].block); },
                                       {}});
          }};
}

PointCloud OrderedPoints::in_order(size_t block_number, const PointBucket& points) const {
  const size_t size = points.indices.size();
  std::vector<uint32_t> from(size, static_cast<uint32_t>(size));
  for (size_t i = 0; i < size; ++i) from[points.indices[i] - block_number * kBlockPoints] = static_cast<uint32_t>(i);
  if (std::find(from.begin(), from.end(), size) != from.end()) fail();
  PointCloud block;
  attributes_.for_each_array(block, points.cloud, [&](auto& ordered, const auto& values) {
    ordered.reserve(size);
    for (const uint32_t i : from) ordered.push_back(values[i]);
  });
  return block;
}

void OrderedPoints::fail() const { throw Error(fmt::format("{}: damaged: the indices of the map's points", map_)); }

}  // namespace cpplus
