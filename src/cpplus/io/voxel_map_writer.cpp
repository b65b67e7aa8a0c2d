#include "cpplus/io/voxel_map_writer.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <utility>

#include "cpplus/cloud/voxel_map_grid.h"
#include "cpplus/core/error.h"
#include "cpplus/io/las_frame_bytes.h"

namespace cpplus {
namespace {

uint32_t extended_checksum(uint32_t checksum, const void* data, size_t size) {
  if (size == 0) return checksum;  // zlib takes no data for the start
  return static_cast<uint32_t>(crc32_z(checksum, static_cast<const unsigned char*>(data), size));
}

constexpr size_t kCopyStep = size_t{1} << 20;

}  // namespace

/// One array of the file. What is as long as the points has its place from the start; what grows with the number of
/// voxels is gathered in a file of its own and copied when that is known.
struct VoxelMapWriter::Section {
  VoxelMapSectionEntry entry;
  std::unique_ptr<ScratchFile> grown;
};

/// A layer as far as it is written.
struct VoxelMapWriter::Layer {
  Section* first = nullptr;
  Section* child_mask = nullptr;
  Section* moments_mask = nullptr;
  Section* moments_rank = nullptr;
  Section* moments = nullptr;
  uint64_t num_nodes = 0;
  uint64_t word = 0;  // of the moments mask, with num_nodes % 64 bits
  uint32_t rank = 0;  // moments before the word
};

VoxelMapWriter::VoxelMapWriter(const std::string& path, const VoxelMapOutline& outline)
    : file_(path), outline_(outline) {
  const VoxelGrid grid(outline.origin, outline.options.root_size_m, outline.options.leaf_size_m);
  layers_.resize(static_cast<size_t>(grid.bits) + 1);
  const auto add_attribute = [&](bool has, VoxelMapSection kind, size_t size) {
    if (has) add_section(kind, 0, size * outline.num_points);
  };
  add_attribute(true, VoxelMapSection::kPositions, sizeof(Eigen::Vector3f));
  add_attribute(true, VoxelMapSection::kInputIndices, sizeof(uint32_t));
  const PointAttributes& has = outline.attributes;
  add_attribute(has.intensities, VoxelMapSection::kIntensities, sizeof(float));
  add_attribute(has.colors, VoxelMapSection::kColors, sizeof(Rgb));
  add_attribute(has.stamps_s, VoxelMapSection::kStamps, sizeof(double));
  add_attribute(has.num_views, VoxelMapSection::kNumViews, sizeof(uint16_t));
  add_attribute(has.best_images, VoxelMapSection::kBestImages, sizeof(uint32_t));
  add_attribute(has.color_spreads, VoxelMapSection::kColorSpreads, sizeof(uint8_t));
  for (size_t l = 0; l < layers_.size(); ++l) {
    const auto add = [&](VoxelMapSection kind) { return add_section(kind, static_cast<uint32_t>(l), std::nullopt); };
    layers_[l].first = add(VoxelMapSection::kFirst);
    if (l + 1 == layers_.size()) continue;
    layers_[l].child_mask = add(VoxelMapSection::kChildMask);
    layers_[l].moments_mask = add(VoxelMapSection::kMomentsMask);
    layers_[l].moments_rank = add(VoxelMapSection::kMomentsRank);
    layers_[l].moments = add(VoxelMapSection::kMoments);
  }
  add_section(VoxelMapSection::kRootKeys, 0, std::nullopt);
  add_section(VoxelMapSection::kRootTable, 0, std::nullopt);
  if (outline.las_frame) {
    Section* frame = add_section(VoxelMapSection::kLasFrame, 0, std::nullopt);
    append<uint8_t>(frame, las_frame_bytes(*outline.las_frame));
  }
  end_ = aligned_offset(sizeof(VoxelMapHeader) + sections_.size() * sizeof(VoxelMapSectionEntry));
  for (const auto& section : sections_) {
    if (section->grown) continue;
    section->entry.offset = end_;
    end_ = aligned_offset(end_ + section->entry.size);
    section->entry.size = 0;  // grows again as it is written
  }
}

VoxelMapWriter::~VoxelMapWriter() = default;

VoxelMapWriter::Section* VoxelMapWriter::add_section(VoxelMapSection kind, uint32_t layer,
                                                     std::optional<uint64_t> size) {
  sections_.push_back(std::make_unique<Section>());
  sections_.back()->entry.kind = kind;
  sections_.back()->entry.layer = layer;
  if (size) {
    sections_.back()->entry.size = *size;
  } else {
    sections_.back()->grown = std::make_unique<ScratchFile>(file_.path());
  }
  return sections_.back().get();
}

void VoxelMapWriter::write_at(uint64_t offset, const void* data, size_t size) {
  file_.stream().seekp(static_cast<std::streamoff>(offset));
  file_.stream().write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
  if (!file_.stream()) throw Error(fmt::format("{}: cannot write all of it: {}", file_.path(), std::strerror(errno)));
}

template <typename T>
void VoxelMapWriter::append(Section* section, std::span<const T> values) {
  VoxelMapSectionEntry& entry = section->entry;
  const size_t size = values.size_bytes();
  if (section->grown) {
    section->grown->write(entry.size, values.data(), size);
  } else {
    write_at(entry.offset + entry.size, values.data(), size);
  }
  entry.checksum = extended_checksum(entry.checksum, values.data(), size);
  entry.size += size;
}

void VoxelMapWriter::append(const PointMap& piece, std::span<const uint32_t> input_indices) {
  const VoxelMapArrays& arrays = piece.map.arrays();
  append_points(piece, input_indices);
  // The lower layers last: a node counts its children from what was written of the layer below before.
  for (size_t l = 0; l < layers_.size(); ++l) append_layer(l, arrays);
  root_keys_.insert(root_keys_.end(), arrays.root_keys.begin(), arrays.root_keys.end());
  num_points_ += arrays.positions.size();
}

void VoxelMapWriter::append_points(const PointMap& piece, std::span<const uint32_t> input_indices) {
  const VoxelMapArrays& arrays = piece.map.arrays();
  for (const auto& section : sections_) {
    switch (section->entry.kind) {
      case VoxelMapSection::kPositions:
        append(section.get(), arrays.positions);
        break;
      case VoxelMapSection::kInputIndices: {
        std::vector<uint32_t> indices(arrays.input_indices.begin(), arrays.input_indices.end());
        for (uint32_t& index : indices) index = input_indices[index];
        append<uint32_t>(section.get(), indices);
        break;
      }
      case VoxelMapSection::kIntensities:
        append(section.get(), piece.intensities);
        break;
      case VoxelMapSection::kColors:
        append(section.get(), piece.colors);
        break;
      case VoxelMapSection::kStamps:
        append(section.get(), piece.stamps_s);
        break;
      case VoxelMapSection::kNumViews:
        append(section.get(), piece.num_views);
        break;
      case VoxelMapSection::kBestImages:
        append(section.get(), piece.best_images);
        break;
      case VoxelMapSection::kColorSpreads:
        append(section.get(), piece.color_spreads);
        break;
      default:
        break;
    }
  }
}

void VoxelMapWriter::append_layer(size_t l, const VoxelMapArrays& arrays) {
  const bool is_leaf = l + 1 == layers_.size();
  const VoxelMapLayer& nodes = arrays.layers[l];
  Layer& layer = layers_[l];
  const size_t num_nodes = nodes.first.size() - 1;
  const auto before = static_cast<uint32_t>(is_leaf ? num_points_ : layers_[l + 1].num_nodes);
  std::vector<uint32_t> first(nodes.first.begin(), nodes.first.end() - 1);
  for (uint32_t& child : first) child += before;
  append<uint32_t>(layer.first, first);
  if (!is_leaf) {
    append(layer.child_mask, nodes.child_mask);
    append(layer.moments, nodes.moments);
    std::vector<uint64_t> words;
    std::vector<uint32_t> ranks;
    for (size_t node = 0; node < num_nodes; ++node) {
      const uint64_t bit = nodes.moments_mask[node / 64] >> (node % 64) & 1u;
      const size_t place = (layer.num_nodes + node) % 64;
      layer.word |= bit << place;
      if (place < 63) continue;
      words.push_back(layer.word);
      ranks.push_back(layer.rank);
      layer.rank += static_cast<uint32_t>(std::popcount(layer.word));
      layer.word = 0;
    }
    append<uint64_t>(layer.moments_mask, words);
    append<uint32_t>(layer.moments_rank, ranks);
  }
  layer.num_nodes += num_nodes;
}

void VoxelMapWriter::finish_layers() {
  for (size_t l = 0; l < layers_.size(); ++l) {
    const bool is_leaf = l + 1 == layers_.size();
    Layer& layer = layers_[l];
    const auto end = static_cast<uint32_t>(is_leaf ? num_points_ : layers_[l + 1].num_nodes);
    append<uint32_t>(layer.first, {&end, 1});
    if (is_leaf || layer.num_nodes % 64 == 0) continue;
    append<uint64_t>(layer.moments_mask, {&layer.word, 1});
    append<uint32_t>(layer.moments_rank, {&layer.rank, 1});
  }
  for (const auto& section : sections_) {
    if (section->entry.kind == VoxelMapSection::kRootKeys) append<Eigen::Vector3i>(section.get(), root_keys_);
    if (section->entry.kind == VoxelMapSection::kRootTable) {
      append<uint32_t>(section.get(), make_root_table(root_keys_));
    }
  }
}

void VoxelMapWriter::place_grown_sections() {
  std::vector<char> block(kCopyStep);
  for (const auto& section : sections_) {
    if (!section->grown) continue;
    VoxelMapSectionEntry& entry = section->entry;
    entry.offset = end_;
    for (uint64_t done = 0; done < entry.size;) {
      const size_t step = static_cast<size_t>(std::min<uint64_t>(kCopyStep, entry.size - done));
      section->grown->read(done, block.data(), step);
      write_at(entry.offset + done, block.data(), step);
      done += step;
    }
    section->grown.reset();
    end_ = aligned_offset(end_ + entry.size);
  }
  // So that the last section, too, ends where the header says that the file does.
  const VoxelMapSectionEntry& last = sections_.back()->entry;
  const std::vector<char> padding(static_cast<size_t>(end_ - last.offset - last.size), '\0');
  write_at(last.offset + last.size, padding.data(), padding.size());
}

void VoxelMapWriter::commit() {
  assert(num_points_ == outline_.num_points);
  finish_layers();
  place_grown_sections();
  VoxelMapHeader header;
  header.file_size = end_;
  header.num_sections = static_cast<uint32_t>(sections_.size());
  header.root_size_m = outline_.options.root_size_m;
  header.leaf_size_m = outline_.options.leaf_size_m;
  header.origin = {outline_.origin.x(), outline_.origin.y(), outline_.origin.z()};
  header.num_points = outline_.num_points;
  header.num_dropped_non_finite = outline_.num_dropped_non_finite;
  std::vector<VoxelMapSectionEntry> table;
  for (const auto& section : sections_) table.push_back(section->entry);
  const size_t table_size = table.size() * sizeof(VoxelMapSectionEntry);
  header.checksum = extended_checksum(extended_checksum(0, &header, sizeof(header)), table.data(), table_size);
  write_at(sizeof(header), table.data(), table_size);
  write_at(0, &header, sizeof(header));
  file_.commit();
}

}  // namespace cpplus
