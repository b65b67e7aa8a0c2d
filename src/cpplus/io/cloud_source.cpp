#include "cpplus/io/cloud_source.h"

#include <algorithm>

namespace cpplus {

CloudBlocks::CloudBlocks(const std::string& path)
    : path_(path), source_(open_point_cloud(path)), builder_(path, 0, source_->fields()) {}

bool CloudBlocks::next(size_t max_points, PointCloud* block) {
  const size_t count = std::min(max_points, source_->num_points() - num_read_);
  if (count == 0) {
    if (num_read_ == num_dropped_) throw_no_finite_points(path_, num_read_);
    return false;
  }
  builder_.swap(block);
  builder_.resize(count);
  source_->read(count, &builder_);
  num_read_ += count;
  num_dropped_ += builder_.drop_non_finite().size();
  builder_.swap(block);
  return true;
}

}  // namespace cpplus
