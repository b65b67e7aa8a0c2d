#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/io/scratch_file.h"
#include "cpplus/io/voxel_map_writer.h"

namespace cpplus {

/// What is known of an index once all of its points are sorted into buckets.
struct SortedPoints {
  VoxelMapOutline outline;
  uint64_t num_roots = 0;
  std::vector<uint64_t> bucket_sizes;  // points
};

/// The folder .NAME.sorted beside a file NAME that is to be made of sorted points: what it holds outlives a process
/// that is killed, and is taken by the next one with the same key (inputs and options; the text may have any length).
/// It goes with this object, unless keep() was called. What is there of another key, or was not sorted to the end, is
/// removed at once.
class KeptSort {
 public:
  /// Where another process is at it, or the folder cannot be made, points are sorted into a file that is not kept.
  KeptSort(const std::string& target, const std::string& key);
  ~KeptSort();
  KeptSort(const KeptSort&) = delete;
  KeptSort& operator=(const KeptSort&) = delete;

  /// What a process before has sorted, if it has: the points are in file().
  const std::optional<SortedPoints>& sorted() const { return sorted_; }
  /// The file for the points; to be called once.
  std::unique_ptr<ScratchFile> file() const;
  /// After all points are in the file. Throws Error where it cannot be written.
  void finish(const SortedPoints& sorted);
  /// Leaves the folder for the next process where all points are sorted.
  void keep() { is_kept_ = is_finished_; }

 private:
  void lock();
  std::string path(const char* name) const;

  std::string target_;
  std::string key_;
  std::string folder_;
  int lock_ = -1;  // < 0: the folder is not ours
  std::optional<SortedPoints> sorted_;
  bool is_finished_ = false;
  bool is_kept_ = false;
};

}  // namespace cpplus
