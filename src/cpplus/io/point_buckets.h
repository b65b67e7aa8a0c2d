#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/io/point_attributes.h"
#include "cpplus/io/scratch_file.h"

namespace cpplus {

/// Points of one bucket in the order in which they came.
struct PointBucket {
  PointCloud cloud;               // its origin is not kept
  std::vector<uint32_t> indices;  // what they were added with
};

/// Consecutive points of a bucket that wait to be written.
struct FullBuffer {
  size_t bucket = 0;
  uint64_t first = 0;  // the place of the first of them in the bucket
  PointBucket points;
};

/// Points sorted into buckets of known sizes, on the disk but for some points a bucket.
class PointBuckets {
 public:
  /// `sizes`: points of each bucket. All buckets together hold at most about buffer_bytes in memory, the rest is in
  /// `file`. Buckets of one that was filled before, with the same sizes and attributes, can be read at once.
  PointBuckets(std::unique_ptr<ScratchFile> file, std::vector<uint64_t> sizes, const PointAttributes& attributes,
               size_t buffer_bytes);

  /// Adds point i of the block. False where the bucket is full already.
  bool add(size_t bucket, const PointCloud& block, size_t i, uint32_t index);
  /// What was filled since this was called last, to be written before finish().
  std::vector<FullBuffer> take_full();
  /// May be called by several threads at a time, also beside add() and take_full().
  void write(std::vector<FullBuffer> buffers);
  /// To be called after the last point. False where a bucket is not full.
  bool finish();
  /// The vectors of `points` are used again.
  void read(size_t bucket, PointBucket* points) const;

 private:
  struct Bucket {
    uint64_t size = 0;
    uint64_t begin = 0;  // of its place in the file, bytes; one array after the other
    uint64_t added = 0;  // points, with those in the buffer
    PointBucket buffer;
  };

  PointBucket empty_buffer();
  FullBuffer take_buffer(size_t bucket);
  void write(FullBuffer* buffer) const;

  PointAttributes attributes_;
  size_t buffer_points_ = 0;
  std::unique_ptr<ScratchFile> file_;
  std::vector<Bucket> buckets_;
  std::vector<FullBuffer> full_;
  std::mutex mutex_;
  std::vector<PointBucket> spare_;  // buffers that were written
};

/// Bytes of a point with these attributes and its index.
size_t point_bytes(const PointAttributes& attributes);

}  // namespace cpplus
