#include "cpplus/io/index_point_clouds.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "cpplus/cloud/root_counts.h"
#include "cpplus/core/error.h"
#include "cpplus/core/interrupt.h"
#include "cpplus/core/memory.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/core/slot_pipeline.h"
#include "cpplus/io/cloud_source.h"
#include "cpplus/io/kept_sort.h"
#include "cpplus/io/point_buckets.h"
#include "cpplus/io/voxel_map_writer.h"

namespace cpplus {
namespace {

constexpr size_t kBlockPoints = 1 << 16;
/// Bytes a point that sorting a bucket and building its nodes take beside the point itself, twice.
constexpr size_t kBuildBytes = 64;
/// Buckets that are read, built and written at a time.
constexpr size_t kBuckets = 3;
/// Share of the memory that points wait in for their bucket; when these are written, others may be full already.
constexpr size_t kBufferShare = 8;

/// Some points of the input, about the origin of all.
struct Block {
  const std::string* path = nullptr;
  PointCloud points;
  size_t first_index = 0;  // of all files' finite points
};

/// The points of all files.
class Inputs {
 public:
  explicit Inputs(const std::vector<std::string>& paths) : paths_(paths) {
    // Bad headers are found before any work.
    for (const std::string& path : paths) {
      const std::unique_ptr<CloudSource> source = open_point_cloud(path);
      num_points_ += source->num_points();
      if (path == paths.front()) las_frame_ = source->las_frame();
    }
  }

  const std::optional<LasFrame>& las_frame() const { return las_frame_; }

  const std::vector<std::string>& paths() const { return paths_; }
  size_t num_points() const { return num_points_; }

 private:
  const std::vector<std::string>& paths_;
  size_t num_points_ = 0;
  std::optional<LasFrame> las_frame_;
};

/// Reads all files from front to back.
class InputBlocks {
 public:
  InputBlocks(const Inputs& inputs, const std::string& label)
      : paths_(inputs.paths()), progress_(label, inputs.num_points()) {}

  /// False behind the last block.
  bool next(Block* block) {
    while (next_path_ < paths_.size()) {
      block->path = &paths_[next_path_];
      if (!file_) file_.emplace(*block->path);
      if (!file_->next(kBlockPoints, &block->points)) {
        num_dropped_ += file_->num_dropped();
        file_.reset();
        ++next_path_;
        continue;
      }
      if (block->points.empty()) continue;
      if (!origin_) origin_ = block->points.origin;
      move_to(*origin_, &block->points);
      block->first_index = num_finite_;
      num_finite_ += block->points.size();
      progress_.advance(block->points.size());
      return true;
    }
    return false;
  }

  /// Points that were not finite, of the files that were read to their end.
  size_t num_dropped() const { return num_dropped_; }

 private:
  static void move_to(const Eigen::Vector3d& origin, PointCloud* cloud) {
    if (cloud->origin == origin) return;
    const Eigen::Vector3d shift = cloud->origin - origin;
    for (Eigen::Vector3f& x : cloud->positions) x = (x.cast<double>() + shift).cast<float>();
    cloud->origin = origin;
  }

  const std::vector<std::string>& paths_;
  Progress progress_;
  size_t next_path_ = 0;
  std::optional<CloudBlocks> file_;
  std::optional<Eigen::Vector3d> origin_;
  size_t num_finite_ = 0;
  size_t num_dropped_ = 0;
};

/// A block and the roots of its points.
struct CountedBlock {
  Block block;
  RootCounts roots;
  std::vector<uint32_t> roots_of_points;  // their indices in `roots`
  std::optional<size_t> beyond_grid;      // the first such point; what is behind it is not counted
};

void count(const VoxelMapOptions& options, CountedBlock* counted) {
  const PointCloud& points = counted->block.points;
  counted->roots.clear();
  counted->roots_of_points.resize(points.size());
  const VoxelGrid grid(points.origin, options.root_size_m, options.leaf_size_m);
  counted->beyond_grid = count_roots(points.positions, grid, &counted->roots, counted->roots_of_points.data());
}

/// Blocks in work at a time.
size_t num_blocks() { return 2 * static_cast<size_t>(num_threads()) + 2; }

/// What the first pass over the points finds.
struct Survey {
  VoxelMapOutline outline;
  RootCounts roots;
};

void add_to_survey(const CountedBlock& counted, Survey* survey) {
  const PointCloud& points = counted.block.points;
  const std::string& path = *counted.block.path;
  VoxelMapOutline& outline = survey->outline;
  outline.origin = points.origin;
  outline.num_points += points.size();
  if (outline.num_points >= no_voxel) {
    throw Error(fmt::format("{}: a voxel map holds fewer than {} points", path, no_voxel));
  }
  if (const auto i = counted.beyond_grid) {
    throw Error(fmt::format(
        "{}: {}", path,
        beyond_grid_message(counted.block.first_index + *i, points.point(*i), outline.options.leaf_size_m)));
  }
  for (size_t r = 0; r < counted.roots.keys.size(); ++r) {
    survey->roots.add(counted.roots.keys[r], counted.roots.counts[r]);
  }
  PointAttributes& has = outline.attributes;
  has.intensities &= !points.intensities.empty();
  has.colors &= !points.colors.empty();
  has.stamps_s &= !points.stamps_s.empty();
  has.num_views &= !points.num_views.empty();
  has.best_images &= !points.best_images.empty();
  has.color_spreads &= !points.color_spreads.empty();
}

Survey survey(const Inputs& inputs, const VoxelMapOptions& options) {
  Survey result;
  result.outline.options = options;
  result.outline.las_frame = inputs.las_frame();
  InputBlocks input(inputs, "survey");
  std::vector<CountedBlock> slots(num_blocks());
  run_slot_pipeline(slots.size(), {[&](size_t slot) { return input.next(&slots[slot].block); },
                                   [&](size_t slot) { count(options, &slots[slot]); },
                                   [&](size_t slot) { add_to_survey(slots[slot], &result); },
                                   {}});
  result.outline.num_dropped_non_finite = input.num_dropped();
  return result;
}

/// Runs of consecutive roots that are built together.
struct BucketPlan {
  std::vector<uint64_t> sizes;           // points of each bucket
  std::vector<uint32_t> bucket_of_root;  // by the roots' order in RootCounts
};

/// As many roots a bucket as its capacity allows, at least one.
BucketPlan plan_buckets(const RootCounts& roots, size_t capacity) {
  std::vector<uint32_t> order(roots.keys.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key_less(roots.keys[a], roots.keys[b]); });
  BucketPlan plan;
  plan.bucket_of_root.resize(order.size());
  for (const uint32_t root : order) {
    const uint64_t size = roots.counts[root];
    if (plan.sizes.empty() || plan.sizes.back() + size > capacity) plan.sizes.push_back(0);
    plan.sizes.back() += size;
    plan.bucket_of_root[root] = static_cast<uint32_t>(plan.sizes.size() - 1);
  }
  return plan;
}

[[noreturn]] void throw_changed(const std::string& path) {
  throw Error(fmt::format("{}: changed while it was read", path));
}

/// A block on its way to the buckets.
struct ScatteredBlock {
  CountedBlock counted;
  std::vector<uint32_t> bucket_of_root;  // by the roots' order in the block; no_voxel for one that is not known
  std::vector<FullBuffer> full;
};

void find_buckets(const RootCounts& roots, const BucketPlan& plan, ScatteredBlock* block) {
  block->bucket_of_root.clear();
  for (const Eigen::Vector3i& key : block->counted.roots.keys) {
    const uint32_t root = roots.find(key);
    block->bucket_of_root.push_back(root == no_voxel ? no_voxel : plan.bucket_of_root[root]);
  }
}

void add_to_buckets(const ScatteredBlock& scattered, PointBuckets* buckets) {
  const Block& block = scattered.counted.block;
  if (scattered.counted.beyond_grid) throw_changed(*block.path);
  for (size_t i = 0; i < block.points.size(); ++i) {
    const uint32_t bucket = scattered.bucket_of_root[scattered.counted.roots_of_points[i]];
    const auto index = static_cast<uint32_t>(block.first_index + i);
    if (bucket == no_voxel || !buckets->add(bucket, block.points, i, index)) throw_changed(*block.path);
  }
}

void scatter(const Inputs& inputs, const VoxelMapOptions& options, const BucketPlan& plan, const RootCounts& roots,
             PointBuckets* buckets) {
  InputBlocks input(inputs, "sort");
  std::vector<ScatteredBlock> slots(num_blocks());
  run_slot_pipeline(slots.size(), {[&](size_t slot) { return input.next(&slots[slot].counted.block); },
                                   [&](size_t slot) {
                                     count(options, &slots[slot].counted);
                                     find_buckets(roots, plan, &slots[slot]);
                                   },
                                   [&](size_t slot) {
                                     add_to_buckets(slots[slot], buckets);
                                     slots[slot].full = buckets->take_full();
                                   },
                                   [&](size_t slot) { buckets->write(std::move(slots[slot].full)); }});
  if (!buckets->finish()) throw_changed(inputs.paths().back());
}

/// A bucket on its way to the file.
struct BuiltBucket {
  PointBucket points;
  PointMap piece;
  VoxelMapWriter::Place place;
};

void build(const PointBuckets& buckets, size_t num_buckets, const VoxelMapOutline& outline, const std::string& out) {
  VoxelMapWriter writer(out, outline);
  Progress progress("build", num_buckets);
  std::vector<BuiltBucket> slots(kBuckets);
  size_t next = 0;
  run_slot_pipeline(kBuckets, {[&](size_t slot) {
                                 if (next == num_buckets) return false;
                                 buckets.read(next++, &slots[slot].points);
                                 return true;
                               },
                               [&](size_t slot) {
                                 BuiltBucket& bucket = slots[slot];
                                 bucket.points.cloud.origin = outline.origin;
                                 bucket.piece = make_point_map(bucket.points.cloud, outline.options);
                               },
                               [&](size_t slot) { slots[slot].place = writer.reserve(slots[slot].piece); },
                               [&](size_t slot) {
                                 BuiltBucket& bucket = slots[slot];
                                 writer.write(bucket.piece, bucket.points.indices, bucket.place);
                                 bucket.piece = {};
                                 progress.advance();
                               }});
  slots = {};
  writer.commit();
}

/// Tells the boot of the system: after a crash files may not hold what was written to them.
std::string boot_id() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string id;
  std::getline(file, id);
  return id;
}

/// What the sorted points depend on.
std::string key_of(const std::vector<std::string>& paths, const VoxelMapOptions& options, size_t memory_bytes) {
  namespace fs = std::filesystem;
  std::string key = fmt::format("{} {} {} {} {}", kVoxelMapVersion, boot_id(), options.root_size_m, options.leaf_size_m,
                                memory_bytes);
  for (const std::string& path : paths) {
    std::error_code failure;
    const auto size = fs::file_size(path, failure);
    const auto time = fs::last_write_time(path, failure).time_since_epoch().count();
    key += fmt::format("\n{} {} {}", fs::absolute(path).lexically_normal().string(), size, time);
  }
  return key;
}

/// Reads all points and sorts them into the file.
std::unique_ptr<PointBuckets> sort_points(const Inputs& inputs, const VoxelMapOptions& options, size_t memory_bytes,
                                          std::unique_ptr<ScratchFile> file, SortedPoints* sorted) {
  Survey found = survey(inputs, options);
  const size_t capacity = memory_bytes / kBuckets / (2 * point_bytes(found.outline.attributes) + kBuildBytes);
  const BucketPlan plan = plan_buckets(found.roots, capacity);
  *sorted = {found.outline, found.roots.keys.size(), plan.sizes};
  auto buckets = std::make_unique<PointBuckets>(std::move(file), plan.sizes, found.outline.attributes,
                                                memory_bytes / kBufferShare);
  scatter(inputs, options, plan, found.roots, buckets.get());
  return buckets;
}

std::unique_ptr<PointBuckets> sorted_before(const SortedPoints& sorted, std::unique_ptr<ScratchFile> file) {
  return std::make_unique<PointBuckets>(std::move(file), sorted.bucket_sizes, sorted.outline.attributes, 0);
}

}  // namespace

IndexSummary index_point_clouds(const std::vector<std::string>& paths, const VoxelMapOptions& options,
                                size_t memory_bytes, const std::string& out) {
  options.validate();
  const std::string key = key_of(paths, options, memory_bytes);  // before anything is read
  const Inputs inputs(paths);
  { const AtomicFile probe(out); }
  KeptSort kept(out, key);
  const bool was_sorted = kept.sorted().has_value();
  SortedPoints sorted = kept.sorted().value_or(SortedPoints());
  const auto buckets = was_sorted ? sorted_before(sorted, kept.file())
                                  : sort_points(inputs, options, memory_bytes, kept.file(), &sorted);
  if (!was_sorted) kept.finish(sorted);
  return_freed_memory();
  try {
    build(*buckets, sorted.bucket_sizes.size(), sorted.outline, out);
  } catch (const Interrupted&) {
    kept.keep();
    throw;
  }
  return {sorted.outline.num_points, sorted.outline.num_dropped_non_finite, sorted.num_roots,
          sorted.bucket_sizes.size(), was_sorted};
}

}  // namespace cpplus
