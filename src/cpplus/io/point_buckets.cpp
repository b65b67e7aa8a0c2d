#include "cpplus/io/point_buckets.h"

#include <algorithm>
#include <utility>

#include "cpplus/core/memory.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

template <typename Array>
constexpr size_t element_size(const Array&) {
  return sizeof(typename Array::value_type);
}

/// Calls visit(array) for each array of a bucket, in the order of the file.
template <typename Bucket, typename Visit>
void for_each_array(const PointAttributes& attributes, Bucket& bucket, const Visit& visit) {
  visit(bucket.indices);
  attributes.for_each_array(bucket.cloud, bucket.cloud, [&](auto& array, auto&) { visit(array); });
}

}  // namespace

size_t point_bytes(const PointAttributes& attributes) {
  size_t bytes = 0;
  PointBucket empty;
  for_each_array(attributes, empty, [&](auto& array) { bytes += element_size(array); });
  return bytes;
}

PointBuckets::PointBuckets(std::unique_ptr<ScratchFile> file, std::vector<uint64_t> sizes,
                           const PointAttributes& attributes, size_t buffer_bytes)
    : attributes_(attributes), file_(std::move(file)), buckets_(sizes.size()) {
  constexpr size_t kFewest = 16, kMost = 1 << 14;
  const size_t bytes = point_bytes(attributes);
  buffer_points_ = std::clamp(buffer_bytes / (bytes * std::max<size_t>(1, sizes.size())), kFewest, kMost);
  uint64_t begin = 0;
  for (size_t b = 0; b < sizes.size(); ++b) {
    buckets_[b].size = sizes[b];
    buckets_[b].begin = begin;
    begin += sizes[b] * bytes;
  }
}

bool PointBuckets::add(size_t bucket, const PointCloud& block, size_t i, uint32_t index) {
  Bucket& to = buckets_[bucket];
  if (to.added == to.size) return false;
  if (to.buffer.indices.capacity() == 0) to.buffer = empty_buffer();
  to.buffer.indices.push_back(index);
  attributes_.for_each_array(to.buffer.cloud, block, [&](auto& array, const auto& from) { array.push_back(from[i]); });
  ++to.added;
  if (to.buffer.indices.size() == buffer_points_) full_.push_back(take_buffer(bucket));
  return true;
}

PointBucket PointBuckets::empty_buffer() {
  {
    const std::lock_guard lock(mutex_);
    if (!spare_.empty()) {
      PointBucket buffer = std::move(spare_.back());
      spare_.pop_back();
      return buffer;
    }
  }
  PointBucket buffer;
  for_each_array(attributes_, buffer, [&](auto& array) { array.reserve(buffer_points_); });
  return buffer;
}

FullBuffer PointBuckets::take_buffer(size_t bucket) {
  Bucket& from = buckets_[bucket];
  return {bucket, from.added - from.buffer.indices.size(), std::exchange(from.buffer, {})};
}

std::vector<FullBuffer> PointBuckets::take_full() { return std::exchange(full_, {}); }

void PointBuckets::write(std::vector<FullBuffer> buffers) {
  for (FullBuffer& buffer : buffers) {
    write(&buffer);
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(buffer.points));
  }
}

void PointBuckets::write(FullBuffer* buffer) const {
  const Bucket& bucket = buckets_[buffer->bucket];
  uint64_t begin = bucket.begin;
  for_each_array(attributes_, buffer->points, [&](auto& array) {
    file_->write(begin + buffer->first * element_size(array), array.data(), array.size() * element_size(array));
    begin += bucket.size * element_size(array);
    array.clear();
  });
}

bool PointBuckets::finish() {
  write(take_full());
  parallel_for_each(buckets_.size(), [this](size_t b) {
    FullBuffer last = take_buffer(b);
    write(&last);
  });
  free_memory(&spare_);
  return std::all_of(buckets_.begin(), buckets_.end(),
                     [](const Bucket& bucket) { return bucket.added == bucket.size; });
}

void PointBuckets::read(size_t bucket, PointBucket* points) const {
  const Bucket& from = buckets_[bucket];
  uint64_t begin = from.begin;
  for_each_array(attributes_, *points, [&](auto& array) {
    array.resize(from.size);
    file_->read(begin, array.data(), array.size() * element_size(array));
    begin += from.size * element_size(array);
  });
}

}  // namespace cpplus
