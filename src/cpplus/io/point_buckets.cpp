#include "cpplus/io/point_buckets.h"

#include <algorithm>
#include <utility>

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
  if (to.written + to.buffer.indices.size() == to.size) return false;
  if (to.buffer.indices.capacity() == 0) {
    for_each_array(attributes_, to.buffer, [&](auto& array) { array.reserve(buffer_points_); });
  }
  to.buffer.indices.push_back(index);
  attributes_.for_each_array(to.buffer.cloud, block, [&](auto& array, const auto& from) { array.push_back(from[i]); });
  if (to.buffer.indices.size() == buffer_points_) flush(&to);
  return true;
}

void PointBuckets::flush(Bucket* bucket) {
  const uint64_t count = bucket->buffer.indices.size();
  uint64_t begin = bucket->begin;
  for_each_array(attributes_, bucket->buffer, [&](auto& array) {
    file_->write(begin + bucket->written * element_size(array), array.data(), array.size() * element_size(array));
    begin += bucket->size * element_size(array);
    array.clear();
  });
  bucket->written += count;
}

bool PointBuckets::finish() {
  for (Bucket& bucket : buckets_) {
    flush(&bucket);
    bucket.buffer = {};
    if (bucket.written != bucket.size) return false;
  }
  return true;
}

PointBucket PointBuckets::read(size_t bucket) const {
  const Bucket& from = buckets_[bucket];
  PointBucket points;
  uint64_t begin = from.begin;
  for_each_array(attributes_, points, [&](auto& array) {
    array.resize(from.size);
    file_->read(begin, array.data(), array.size() * element_size(array));
    begin += from.size * element_size(array);
  });
  return points;
}

}  // namespace cpplus
