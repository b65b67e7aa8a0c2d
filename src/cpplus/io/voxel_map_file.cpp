#include "cpplus/io/voxel_map_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "cpplus/cloud/voxel_map_grid.h"
#include "cpplus/core/error.h"
#include "cpplus/io/las_frame_bytes.h"
#include "cpplus/io/mapped_file.h"
#include "cpplus/io/text_parse.h"
#include "cpplus/io/voxel_map_format.h"

namespace cpplus {
namespace {

const char* section_name(VoxelMapSection kind) {
  switch (kind) {
    case VoxelMapSection::kPositions:
      return "positions";
    case VoxelMapSection::kInputIndices:
      return "input indices";
    case VoxelMapSection::kRootKeys:
      return "root keys";
    case VoxelMapSection::kRootTable:
      return "root table";
    case VoxelMapSection::kFirst:
      return "first children";
    case VoxelMapSection::kChildMask:
      return "child masks";
    case VoxelMapSection::kMomentsMask:
      return "moments mask";
    case VoxelMapSection::kMomentsRank:
      return "moments rank";
    case VoxelMapSection::kMoments:
      return "moments";
    case VoxelMapSection::kIntensities:
      return "intensities";
    case VoxelMapSection::kColors:
      return "colours";
    case VoxelMapSection::kStamps:
      return "stamps";
    case VoxelMapSection::kNumViews:
      return "view counts";
    case VoxelMapSection::kBestImages:
      return "best images";
    case VoxelMapSection::kColorSpreads:
      return "colour spreads";
    case VoxelMapSection::kLasFrame:
      return "LAS frame";
  }
  return "unknown";
}

uint32_t checksum_of(const VoxelMapHeader& header, std::span<const VoxelMapSectionEntry> table) {
  VoxelMapHeader without = header;
  without.checksum = 0;
  const uLong of_header = crc32_z(0, reinterpret_cast<const Bytef*>(&without), sizeof(without));
  return static_cast<uint32_t>(crc32_z(of_header, reinterpret_cast<const Bytef*>(table.data()), table.size_bytes()));
}

/// The mapped file with its header and table, which are in order.
class VoxelMapFile {
 public:
  explicit VoxelMapFile(const std::string& path) : path_(path), file_(std::make_shared<const MappedFile>(path)) {
    const std::span<const uint8_t> bytes = file_->bytes();
    const size_t head = std::min(bytes.size(), sizeof(header_));
    if (head > 0) std::memcpy(&header_, bytes.data(), head);
    if (head < sizeof(kVoxelMapMagic) || header_.magic != kVoxelMapMagic) fail("not a voxel map file");
    if (head < sizeof(header_)) fail(fmt::format("truncated: its {} bytes do not hold the header", bytes.size()));
    if (header_.byte_order != kByteOrderMark)
      fail("was written by a machine of another byte order: index the map again");
    if (header_.version != kVoxelMapVersion) {
      fail(fmt::format("has format version {}, this program reads version {}: index the map again", header_.version,
                       kVoxelMapVersion));
    }
    if (header_.file_size != bytes.size()) {
      fail(fmt::format("{}: {} bytes instead of {}", header_.file_size > bytes.size() ? "truncated" : "too long",
                       bytes.size(), header_.file_size));
    }
    if (header_.num_sections > (bytes.size() - sizeof(header_)) / sizeof(VoxelMapSectionEntry)) {
      fail(fmt::format("damaged: a table of {} sections does not fit", header_.num_sections));
    }
    table_.resize(header_.num_sections);
    std::memcpy(table_.data(), bytes.data() + sizeof(header_), table_.size() * sizeof(VoxelMapSectionEntry));
    if (checksum_of(header_, table_) != header_.checksum) fail("damaged: header and table have a wrong checksum");
    check_places();
  }

  const VoxelMapHeader& header() const { return header_; }
  const std::vector<VoxelMapSectionEntry>& table() const { return table_; }
  const std::shared_ptr<const MappedFile>& file() const { return file_; }

  std::span<const uint8_t> content(const VoxelMapSectionEntry& entry) const {
    return file_->bytes().subspan(entry.offset, entry.size);
  }

  const VoxelMapSectionEntry* find(VoxelMapSection kind, uint32_t layer = 0) const {
    const auto entry =
        std::find_if(table_.begin(), table_.end(), [&](const auto& e) { return e.kind == kind && e.layer == layer; });
    return entry == table_.end() ? nullptr : &*entry;
  }

  /// The values of a section that must be there, `size` of them where it is given.
  template <typename T>
  std::span<const T> values(VoxelMapSection kind, uint32_t layer = 0, std::optional<uint64_t> size = {}) const {
    const VoxelMapSectionEntry* entry = find(kind, layer);
    if (entry == nullptr) fail(fmt::format("damaged: section {} of layer {} is missing", section_name(kind), layer));
    const uint64_t held = entry->size / sizeof(T);
    if (entry->size % sizeof(T) != 0 || (size && held != *size)) {
      fail(fmt::format("damaged: section {} of layer {} has {} bytes, not those of {} entries", section_name(kind),
                       layer, entry->size, size.value_or(held)));
    }
    return {reinterpret_cast<const T*>(content(*entry).data()), held};
  }

  /// An attribute of the points; empty where the map does not have it.
  template <typename T>
  std::span<const T> attribute(VoxelMapSection kind) const {
    if (find(kind) == nullptr) return {};
    return values<T>(kind, 0, header_.num_points);
  }

  [[noreturn]] void fail(const std::string& what) const { throw Error(fmt::format("{}: {}", path_, what)); }

 private:
  void check_places() const {
    for (const VoxelMapSectionEntry& entry : table_) {
      const bool inside = entry.offset <= header_.file_size && entry.size <= header_.file_size - entry.offset;
      if (!inside || entry.offset % kSectionAlignment != 0) {
        fail(fmt::format("damaged: section {} at byte {} with {} bytes has no place in the file",
                         section_name(entry.kind), entry.offset, entry.size));
      }
    }
  }

  std::string path_;
  std::shared_ptr<const MappedFile> file_;
  VoxelMapHeader header_;
  std::vector<VoxelMapSectionEntry> table_;
};

/// One layer; `num_below` is the number of nodes of the layer below, of points for the leaves.
VoxelMapLayer layer_of(const VoxelMapFile& file, uint32_t l, bool is_leaf, uint64_t num_nodes, uint64_t num_below) {
  VoxelMapLayer layer;
  layer.first = file.values<uint32_t>(VoxelMapSection::kFirst, l, num_nodes + 1);
  if (layer.first.front() != 0 || layer.first.back() != num_below) {
    file.fail(fmt::format("damaged: section first children of layer {} does not end with the layer below", l));
  }
  if (is_leaf) return layer;
  const uint64_t num_words = (num_nodes + 63) / 64;
  layer.child_mask = file.values<uint8_t>(VoxelMapSection::kChildMask, l, num_nodes);
  layer.moments_mask = file.values<uint64_t>(VoxelMapSection::kMomentsMask, l, num_words);
  layer.moments_rank = file.values<uint32_t>(VoxelMapSection::kMomentsRank, l, num_words);
  layer.moments = file.values<VoxelMoments>(VoxelMapSection::kMoments, l);
  const uint64_t num_moments =
      num_words == 0 ? 0 : layer.moments_rank.back() + static_cast<uint64_t>(std::popcount(layer.moments_mask.back()));
  if (layer.moments.size() != num_moments) {
    file.fail(fmt::format("damaged: layer {} has {} moments, its mask says {}", l, layer.moments.size(), num_moments));
  }
  return layer;
}

VoxelMapArrays arrays_of(const VoxelMapFile& file, size_t num_layers) {
  const VoxelMapHeader& header = file.header();
  VoxelMapArrays arrays;
  arrays.positions = file.values<Eigen::Vector3f>(VoxelMapSection::kPositions, 0, header.num_points);
  arrays.input_indices = file.values<uint32_t>(VoxelMapSection::kInputIndices, 0, header.num_points);
  arrays.root_keys = file.values<Eigen::Vector3i>(VoxelMapSection::kRootKeys);
  arrays.root_table = file.values<uint32_t>(VoxelMapSection::kRootTable);
  if (!std::has_single_bit(arrays.root_table.size()) || arrays.root_table.size() <= arrays.root_keys.size()) {
    file.fail(
        fmt::format("damaged: a table of {} slots for {} roots", arrays.root_table.size(), arrays.root_keys.size()));
  }
  std::vector<uint64_t> num_nodes = {arrays.root_keys.size()};
  for (uint32_t l = 1; l < num_layers; ++l) {
    const uint64_t size = file.values<uint32_t>(VoxelMapSection::kFirst, l).size();
    if (size == 0) file.fail(fmt::format("damaged: section first children of layer {} is empty", l));
    num_nodes.push_back(size - 1);
  }
  num_nodes.push_back(header.num_points);
  for (uint32_t l = 0; l < num_layers; ++l) {
    arrays.layers.push_back(layer_of(file, l, l + 1 == num_layers, num_nodes[l], num_nodes[l + 1]));
  }
  arrays.owner = file.file();
  return arrays;
}

VoxelMapOptions options_of(const VoxelMapFile& file) {
  VoxelMapOptions options;
  options.root_size_m = file.header().root_size_m;
  options.leaf_size_m = file.header().leaf_size_m;
  try {
    options.validate();
  } catch (const Error& error) {
    file.fail(fmt::format("damaged: {}", error.what()));
  }
  return options;
}

}  // namespace

bool is_voxel_map_file(const std::string& path) {
  return lower_case(std::filesystem::path(path).extension().string()) == ".vox";
}

PointMap map_voxel_map_file(const std::string& path) {
  const VoxelMapFile file(path);
  const VoxelMapHeader& header = file.header();
  const VoxelMapOptions options = options_of(file);
  const Eigen::Vector3d origin(header.origin[0], header.origin[1], header.origin[2]);
  if (header.num_points == 0 || header.num_points >= no_voxel || !origin.allFinite()) {
    file.fail(fmt::format("damaged: {} points", header.num_points));
  }
  const VoxelGrid grid(origin, options.root_size_m, options.leaf_size_m);
  PointMap points;
  points.map = VoxelMap(origin, options, arrays_of(file, static_cast<size_t>(grid.bits) + 1));
  points.intensities = file.attribute<float>(VoxelMapSection::kIntensities);
  points.colors = file.attribute<Rgb>(VoxelMapSection::kColors);
  points.stamps_s = file.attribute<double>(VoxelMapSection::kStamps);
  points.num_views = file.attribute<uint16_t>(VoxelMapSection::kNumViews);
  points.best_images = file.attribute<uint32_t>(VoxelMapSection::kBestImages);
  points.color_spreads = file.attribute<uint8_t>(VoxelMapSection::kColorSpreads);
  if (file.find(VoxelMapSection::kLasFrame) != nullptr) {
    points.las_frame = parse_las_frame(file.values<uint8_t>(VoxelMapSection::kLasFrame));
    if (!points.las_frame) file.fail("damaged: section LAS frame");
  }
  points.num_dropped_non_finite = header.num_dropped_non_finite;
  points.owner = file.file();
  return points;
}

std::string voxel_map_fingerprint(const std::string& path) {
  const VoxelMapFile file(path);
  return fmt::format("{}-{:08x}", file.header().file_size, file.header().checksum);
}

void verify_voxel_map_file(const std::string& path) {
  const VoxelMapFile file(path);
  for (const VoxelMapSectionEntry& entry : file.table()) {
    const std::span<const uint8_t> content = file.content(entry);
    const uLong checksum = content.empty() ? 0 : crc32_z(0, content.data(), content.size());
    if (checksum == entry.checksum) continue;
    file.fail(
        fmt::format("damaged: section {} of layer {} has a wrong checksum", section_name(entry.kind), entry.layer));
  }
}

}  // namespace cpplus
