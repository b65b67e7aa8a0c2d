#include "cpplus/io/index_point_clouds.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "cpplus/cloud/root_counts.h"
#include "cpplus/core/error.h"
#include "cpplus/core/interrupt.h"
#include "cpplus/core/memory.h"
#include "cpplus/core/progress.h"
#include "cpplus/io/cloud_source.h"
#include "cpplus/io/kept_sort.h"
#include "cpplus/io/point_buckets.h"
#include "cpplus/io/voxel_map_writer.h"

namespace cpplus {
namespace {

constexpr size_t kBlockPoints = 1 << 16;
/// Bytes a point that sorting a bucket and building its nodes take beside the point itself, twice.
constexpr size_t kBuildBytes = 64;
/// Share of the memory that points wait in for their bucket.
constexpr size_t kBufferShare = 4;

/// Some points of the input, about the origin of all.
struct Block {
  const std::string& path;
  const PointCloud& points;
  size_t first_index;  // of all files' finite points
};

/// The points of all files, block by block.
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

  /// Returns the number of points that were not finite.
  size_t for_each_block(const std::string& label, const std::function<void(const Block&)>& body) const {
    Progress progress(label, num_points_);
    std::optional<Eigen::Vector3d> origin;
    size_t num_finite = 0, num_dropped = 0;
    for (const std::string& path : paths_) {
      CloudBlocks blocks(path);
      PointCloud moved;
      while (const PointCloud* block = blocks.next(kBlockPoints)) {
        check_interrupt();
        if (block->empty()) continue;
        if (!origin) origin = block->origin;
        const bool is_in_place = block->origin == *origin;
        if (!is_in_place) moved = about(*origin, *block);
        body({path, is_in_place ? *block : moved, num_finite});
        num_finite += block->size();
        progress.advance(block->size());
      }
      num_dropped += blocks.num_dropped();
    }
    return num_dropped;
  }

 private:
  static PointCloud about(const Eigen::Vector3d& origin, PointCloud cloud) {
    const Eigen::Vector3d shift = cloud.origin - origin;
    for (Eigen::Vector3f& x : cloud.positions) x = (x.cast<double>() + shift).cast<float>();
    cloud.origin = origin;
    return cloud;
  }

  const std::vector<std::string>& paths_;
  size_t num_points_ = 0;
  std::optional<LasFrame> las_frame_;
};

/// What the first pass over the points finds.
struct Survey {
  VoxelMapOutline outline;
  RootCounts roots;
};

Survey survey(const Inputs& inputs, const VoxelMapOptions& options) {
  Survey result;
  VoxelMapOutline& outline = result.outline;
  outline.options = options;
  outline.las_frame = inputs.las_frame();
  std::vector<uint32_t> roots_of_points(kBlockPoints);
  outline.num_dropped_non_finite = inputs.for_each_block("survey", [&](const Block& block) {
    const PointCloud& points = block.points;
    outline.origin = points.origin;
    outline.num_points += points.size();
    if (outline.num_points >= no_voxel) {
      throw Error(fmt::format("{}: a voxel map holds fewer than {} points", block.path, no_voxel));
    }
    const VoxelGrid grid(points.origin, options.root_size_m, options.leaf_size_m);
    if (const auto i = count_roots(points.positions, grid, &result.roots, roots_of_points.data())) {
      throw Error(fmt::format("{}: {}", block.path,
                              beyond_grid_message(block.first_index + *i, points.point(*i), options.leaf_size_m)));
    }
    PointAttributes& has = outline.attributes;
    has.intensities &= !points.intensities.empty();
    has.colors &= !points.colors.empty();
    has.stamps_s &= !points.stamps_s.empty();
    has.num_views &= !points.num_views.empty();
    has.best_images &= !points.best_images.empty();
    has.color_spreads &= !points.color_spreads.empty();
  });
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

void scatter(const Inputs& inputs, const VoxelMapOptions& options, const BucketPlan& plan, RootCounts* roots,
             PointBuckets* buckets) {
  std::string last_path;
  std::vector<uint32_t> roots_of_points(kBlockPoints);
  inputs.for_each_block("sort", [&](const Block& block) {
    const PointCloud& points = block.points;
    const VoxelGrid grid(points.origin, options.root_size_m, options.leaf_size_m);
    if (count_roots(points.positions, grid, roots, roots_of_points.data())) throw_changed(block.path);
    for (size_t i = 0; i < points.size(); ++i) {
      const uint32_t root = roots_of_points[i];
      const bool is_known = root < plan.bucket_of_root.size();
      if (!is_known ||
          !buckets->add(plan.bucket_of_root[root], points, i, static_cast<uint32_t>(block.first_index + i))) {
        throw_changed(block.path);
      }
    }
    last_path = block.path;
  });
  if (!buckets->finish()) throw_changed(last_path);
}

void build(const PointBuckets& buckets, size_t num_buckets, const VoxelMapOutline& outline, const std::string& out) {
  VoxelMapWriter writer(out, outline);
  Progress progress("build", num_buckets);
  for (size_t b = 0; b < num_buckets; ++b) {
    check_interrupt();
    PointBucket bucket = buckets.read(b);
    bucket.cloud.origin = outline.origin;
    const PointMap piece = make_point_map(bucket.cloud, outline.options);
    bucket.cloud = {};
    writer.append(piece, bucket.indices);
    return_freed_memory();
    progress.advance();
  }
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
PointBuckets sort_points(const Inputs& inputs, const VoxelMapOptions& options, size_t memory_bytes,
                         std::unique_ptr<ScratchFile> file, SortedPoints* sorted) {
  Survey found = survey(inputs, options);
  const size_t capacity = memory_bytes / (2 * point_bytes(found.outline.attributes) + kBuildBytes);
  const BucketPlan plan = plan_buckets(found.roots, capacity);
  *sorted = {found.outline, found.roots.keys.size(), plan.sizes};
  PointBuckets buckets(std::move(file), plan.sizes, found.outline.attributes, memory_bytes / kBufferShare);
  scatter(inputs, options, plan, &found.roots, &buckets);
  return buckets;
}

PointBuckets sorted_before(const SortedPoints& sorted, std::unique_ptr<ScratchFile> file) {
  return {std::move(file), sorted.bucket_sizes, sorted.outline.attributes, 0};
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
  const PointBuckets buckets = was_sorted ? sorted_before(sorted, kept.file())
                                          : sort_points(inputs, options, memory_bytes, kept.file(), &sorted);
  if (!was_sorted) kept.finish(sorted);
  return_freed_memory();
  try {
    build(buckets, sorted.bucket_sizes.size(), sorted.outline, out);
  } catch (const Interrupted&) {
    kept.keep();
    throw;
  }
  return {sorted.outline.num_points, sorted.outline.num_dropped_non_finite, sorted.num_roots,
          sorted.bucket_sizes.size(), was_sorted};
}

}  // namespace cpplus
