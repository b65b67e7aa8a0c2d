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

/// What a piece has for a section, as it is in the piece; nothing for what pieces do not hold whole.
std::span<const std::byte> content(const VoxelMapSectionEntry& entry, const PointMap& piece) {
  const VoxelMapArrays& arrays = piece.map.arrays();
  const auto layer = [&]() -> const VoxelMapLayer& { return arrays.layers[entry.layer]; };
  switch (entry.kind) {
    case VoxelMapSection::kPositions:
      return std::as_bytes(arrays.positions);
    case VoxelMapSection::kInputIndices:
      return std::as_bytes(arrays.input_indices);
    case VoxelMapSection::kIntensities:
      return std::as_bytes(piece.intensities);
    case VoxelMapSection::kColors:
      return std::as_bytes(piece.colors);
    case VoxelMapSection::kStamps:
      return std::as_bytes(piece.stamps_s);
    case VoxelMapSection::kNumViews:
      return std::as_bytes(piece.num_views);
    case VoxelMapSection::kBestImages:
      return std::as_bytes(piece.best_images);
    case VoxelMapSection::kColorSpreads:
      return std::as_bytes(piece.color_spreads);
    case VoxelMapSection::kFirst:
      return std::as_bytes(layer().first.first(layer().first.size() - 1));
    case VoxelMapSection::kChildMask:
      return std::as_bytes(layer().child_mask);
    case VoxelMapSection::kMoments:
      return std::as_bytes(layer().moments);
    case VoxelMapSection::kRootKeys:
    case VoxelMapSection::kRootTable:
    case VoxelMapSection::kMomentsMask:
    case VoxelMapSection::kMomentsRank:
    case VoxelMapSection::kLasFrame:
      return {};
  }
  return {};
}

}  // namespace

/// One array of the file. What is as long as the points has its place from the start; what grows with the number of
/// voxels is gathered in a file of its own and copied when that is known.
struct VoxelMapWriter::Section {
  VoxelMapSectionEntry entry;
  std::unique_ptr<ScratchFile> grown;
  size_t index = 0;  // in the file
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
    : file_(path), out_(path, file_.temporary()), outline_(outline) {
  const VoxelGrid grid(outline.origin, outline.options.root_size_m, outline.options.leaf_size_m);
  layers_.resize(static_cast<size_t>(grid.bits) + 1);
  const auto add_attribute = [&](bool has, VoxelMapSection kind, size_t size) {
    if (has) add_section(kind, 0, size * outline.num_points);
  };
  positions_ = add_section(VoxelMapSection::kPositions, 0, sizeof(Eigen::Vector3f) * outline.num_points);
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
  sections_.back()->index = sections_.size() - 1;
  if (size) {
    sections_.back()->entry.size = *size;
  } else {
    sections_.back()->grown = std::make_unique<ScratchFile>(file_.path());
  }
  return sections_.back().get();
}

/// `offset`: in the section.
void VoxelMapWriter::write_at(const Section& section, uint64_t offset, const void* data, size_t size) {
  if (section.grown) {
    section.grown->write(offset, data, size);
  } else {
    out_.write(section.entry.offset + offset, data, size);
  }
}

template <typename T>
void VoxelMapWriter::append(Section* section, std::span<const T> values) {
  VoxelMapSectionEntry& entry = section->entry;
  write_at(*section, entry.size, values.data(), values.size_bytes());
  entry.checksum = extended_checksum(entry.checksum, values.data(), values.size_bytes());
  entry.size += values.size_bytes();
}

VoxelMapWriter::Place VoxelMapWriter::reserve(const PointMap& piece) {
  const VoxelMapArrays& arrays = piece.map.arrays();
  Place place{num_pieces_++, {}};
  for (const auto& section : sections_) {
    place.begins.push_back(section->entry.size);
    section->entry.size += content(section->entry, piece).size();
  }
  for (size_t l = 0; l + 1 < layers_.size(); ++l) append_moments_mask(l, arrays.layers[l]);
  root_keys_.insert(root_keys_.end(), arrays.root_keys.begin(), arrays.root_keys.end());
  num_points_ += arrays.positions.size();
  return place;
}

/// What the nodes of layer l count their children from: nodes of the layer below, or points.
uint32_t VoxelMapWriter::children_before(size_t l, const Place& place) const {
  const bool is_leaf = l + 1 == layers_.size();
  const uint64_t begin = place.begins[is_leaf ? positions_->index : layers_[l + 1].first->index];
  return static_cast<uint32_t>(begin / (is_leaf ? sizeof(Eigen::Vector3f) : sizeof(uint32_t)));
}

void VoxelMapWriter::write(const PointMap& piece, std::span<const uint32_t> input_indices, const Place& place) {
  std::vector<Part> parts(sections_.size());
  for (size_t s = 0; s < sections_.size(); ++s) {
    const VoxelMapSectionEntry& entry = sections_[s]->entry;
    std::span<const std::byte> bytes = content(entry, piece);
    std::vector<uint32_t> changed;
    if (entry.kind == VoxelMapSection::kInputIndices) {
      const std::span<const uint32_t> indices = piece.map.arrays().input_indices;
      changed.assign(indices.begin(), indices.end());
      for (uint32_t& index : changed) index = input_indices[index];
      bytes = std::as_bytes(std::span(changed));
    } else if (entry.kind == VoxelMapSection::kFirst) {
      const std::span<const uint32_t> first = piece.map.arrays().layers[entry.layer].first;
      changed.assign(first.begin(), first.end() - 1);
      const uint32_t before = children_before(entry.layer, place);
      for (uint32_t& child : changed) child += before;
      bytes = std::as_bytes(std::span(changed));
    }
    write_at(*sections_[s], place.begins[s], bytes.data(), bytes.size());
    parts[s] = {bytes.size(), extended_checksum(0, bytes.data(), bytes.size())};
  }
  const std::lock_guard lock(mutex_);
  if (parts_.size() <= place.piece) parts_.resize(place.piece + 1);
  parts_[place.piece] = std::move(parts);
}

/// The mask and the ranks: one word holds the nodes of two pieces where they meet.
void VoxelMapWriter::append_moments_mask(size_t l, const VoxelMapLayer& nodes) {
  Layer& layer = layers_[l];
  const size_t num_nodes = nodes.first.size() - 1;
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
  layer.num_nodes += num_nodes;
}

void VoxelMapWriter::join_checksums() {
  for (const std::vector<Part>& parts : parts_) {
    for (size_t s = 0; s < sections_.size(); ++s) {
      if (parts[s].size == 0) continue;
      VoxelMapSectionEntry& entry = sections_[s]->entry;
      entry.checksum =
          static_cast<uint32_t>(crc32_combine(entry.checksum, parts[s].checksum, static_cast<z_off_t>(parts[s].size)));
    }
  }
}

void VoxelMapWriter::finish_layers() {
  for (size_t l = 0; l < layers_.size(); ++l) {
    const bool is_leaf = l + 1 == layers_.size();
    Layer& layer = layers_[l];
    const auto end = static_cast<uint32_t>(is_leaf ? num_points_ : layers_[l + 1].first->entry.size / sizeof(uint32_t));
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
      out_.write(entry.offset + done, block.data(), step);
      done += step;
    }
    section->grown.reset();
    end_ = aligned_offset(end_ + entry.size);
  }
  // So that the last section, too, ends where the header says that the file does.
  const VoxelMapSectionEntry& last = sections_.back()->entry;
  const std::vector<char> padding(static_cast<size_t>(end_ - last.offset - last.size), '\0');
  out_.write(last.offset + last.size, padding.data(), padding.size());
}

void VoxelMapWriter::commit() {
  assert(num_points_ == outline_.num_points);
  join_checksums();
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
  out_.write(sizeof(header), table.data(), table_size);
  out_.write(0, &header, sizeof(header));
  file_.commit();
}

}  // namespace cpplus
