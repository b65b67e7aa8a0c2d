#include "cpplus/io/kept_sort.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <span>
#include <utility>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/byte_packer.h"
#include "cpplus/io/las_frame_bytes.h"
#include "cpplus/io/mapped_file.h"
#include "cpplus/io/point_buckets.h"

namespace cpplus {
namespace fs = std::filesystem;

namespace {

constexpr const char* kLock = "lock";
constexpr const char* kPoints = "points";
constexpr const char* kPlan = "plan";

template <typename Archive, typename Sorted>
void transfer_sorted(Archive& archive, Sorted& sorted) {
  auto& outline = sorted.outline;
  archive.number(outline.options.root_size_m);
  archive.number(outline.options.leaf_size_m);
  archive.matrix(outline.origin);
  archive.number(outline.num_points);
  archive.number(outline.num_dropped_non_finite);
  auto& has = outline.attributes;
  for (auto* attribute :
       {&has.intensities, &has.colors, &has.stamps_s, &has.num_views, &has.best_images, &has.color_spreads}) {
    archive.number(*attribute);
  }
  archive.number(sorted.num_roots);
  archive.size(sorted.bucket_sizes);
  archive.matrix(sorted.bucket_sizes);
}

uint32_t plan_checksum(const void* data, size_t size) {
  return static_cast<uint32_t>(crc32_z(0, static_cast<const Bytef*>(data), size));
}

/// The key and what is sorted, with the checksum of all that before them.
std::string plan_bytes(const std::string& key, const SortedPoints& sorted) {
  std::string bytes;
  BytePacker packer(&bytes);
  packer.size(key);
  packer.matrix(key);
  std::vector<uint8_t> las_frame;
  if (sorted.outline.las_frame) las_frame = las_frame_bytes(*sorted.outline.las_frame);
  packer.size(las_frame);
  packer.matrix(las_frame);
  transfer_sorted(packer, sorted);
  const uint32_t checksum = plan_checksum(bytes.data(), bytes.size());
  return std::string(reinterpret_cast<const char*>(&checksum), sizeof(checksum)) + bytes;
}

std::optional<SortedPoints> read_plan(const std::string& path, const std::string& expected_key) {
  if (!fs::exists(path)) return std::nullopt;
  const MappedFile file(path);
  std::span<const uint8_t> bytes = file.bytes();
  uint32_t checksum = 0;
  if (bytes.size() < sizeof(checksum)) return std::nullopt;
  std::memcpy(&checksum, bytes.data(), sizeof(checksum));
  bytes = bytes.subspan(sizeof(checksum));
  if (plan_checksum(bytes.data(), bytes.size()) != checksum) return std::nullopt;
  ByteUnpacker unpacker(bytes);
  std::string key;
  std::vector<uint8_t> las_frame;
  SortedPoints sorted;
  unpacker.size(key);
  unpacker.matrix(key);
  unpacker.size(las_frame);
  unpacker.matrix(las_frame);
  transfer_sorted(unpacker, sorted);
  if (!unpacker.is_at_end() || key != expected_key) return std::nullopt;
  if (!las_frame.empty()) sorted.outline.las_frame = parse_las_frame(las_frame);
  return sorted;
}

bool holds_all(const std::string& path, const SortedPoints& sorted) {
  std::error_code failure;
  const auto size = fs::file_size(path, failure);
  return !failure && size == sorted.outline.num_points * point_bytes(sorted.outline.attributes);
}

}  // namespace

KeptSort::KeptSort(const std::string& target, const std::string& key) : target_(target), key_(key) {
  const fs::path path_of_target(target);
  folder_ = (path_of_target.parent_path() / fmt::format(".{}.sorted", path_of_target.filename().string())).string();
  lock();
  if (lock_ < 0) return;
  try {
    sorted_ = read_plan(path(kPlan), key_);
  } catch (const Error&) {
    // Cannot be read: sorted anew.
  }
  if (sorted_ && !holds_all(path(kPoints), *sorted_)) sorted_.reset();
  is_finished_ = sorted_.has_value();
  if (sorted_) return;
  std::error_code ignored;
  for (const char* name : {kPlan, kPoints}) fs::remove_all(path(name), ignored);
}

KeptSort::~KeptSort() {
  if (lock_ < 0) return;
  std::error_code ignored;
  if (!is_kept_) fs::remove_all(folder_, ignored);
  close(lock_);  // only now, so that nobody takes what is being removed
}

/// The system unlocks the file when the process ends, however that is.
void KeptSort::lock() {
  std::error_code failure;
  fs::create_directories(folder_, failure);
  const int file = open(path(kLock).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (file < 0) return;
  struct stat status {};
  const bool is_ours = flock(file, LOCK_EX | LOCK_NB) == 0 && fstat(file, &status) == 0 && status.st_nlink > 0;
  if (is_ours) {
    lock_ = file;
  } else {
    close(file);
  }
}

std::string KeptSort::path(const char* name) const { return (fs::path(folder_) / name).string(); }

std::unique_ptr<ScratchFile> KeptSort::file() const {
  return lock_ < 0 ? std::make_unique<ScratchFile>(target_) : std::make_unique<ScratchFile>(target_, path(kPoints));
}

void KeptSort::finish(const SortedPoints& sorted) {
  if (lock_ < 0) return;
  write_text_file(path(kPlan), plan_bytes(key_, sorted));
  is_finished_ = true;
}

}  // namespace cpplus
