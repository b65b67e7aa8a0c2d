#include "cpplus/io/tile_features_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <span>
#include <type_traits>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/byte_packer.h"
#include "cpplus/io/mapped_file.h"

namespace cpplus {
namespace {

constexpr std::array<char, 8> kTileMagic = {'C', 'P', '+', 'T', 'I', 'L', 'E', 'S'};

struct Header {
  std::array<char, 8> magic = kTileMagic;
  uint32_t byte_order = 0x01020304;
  uint32_t version = kTileFeaturesVersion;
  uint64_t file_size = 0;  // bytes
  uint32_t checksum = 0;   // CRC-32 of all that follows the header
  uint32_t key_size = 0;   // bytes
};
static_assert(sizeof(Header) == 32 && std::is_trivially_copyable_v<Header>);

uint32_t content_checksum(const uint8_t* data, size_t size) { return static_cast<uint32_t>(crc32_z(0, data, size)); }

template <typename Archive, typename Planes>
void transfer_planes(Archive& archive, Planes& planes) {
  archive.size(planes);
  for (auto& plane : planes) {
    archive.matrix(plane.plane.normal);
    archive.matrix(plane.plane.centroid);
    archive.number(plane.plane.sigma_m);
    archive.number(plane.plane.num_points);
    archive.number(plane.own.count);
    archive.matrix(plane.own.mean);
    archive.matrix(plane.own.covariance);
  }
}

template <typename Archive, typename Patches>
void transfer_patches(Archive& archive, Patches& patches) {
  archive.size(patches);
  for (auto& patch : patches) {
    archive.number(patch.leaf);
    archive.number(patch.plane);
    archive.matrix(patch.center);
  }
}

template <typename Archive, typename Edges>
void transfer_edges(Archive& archive, Edges& edges) {
  archive.size(edges);
  for (auto& edge : edges) {
    auto kind = static_cast<uint32_t>(edge.kind);
    archive.number(kind);
    if constexpr (!std::is_const_v<Edges>) edge.kind = static_cast<MapEdgeKind>(kind);
    archive.number(edge.group);
    for (auto* vector : {&edge.start, &edge.end, &edge.normal_a, &edge.normal_b, &edge.inward_a, &edge.inward_b}) {
      archive.matrix(*vector);
    }
    archive.matrix(edge.covariance);
  }
}

template <typename Archive, typename Features>
void transfer_features(Archive& archive, Features& features) {
  archive.number(features.noise_m);
  archive.number(features.num_points);
  transfer_planes(archive, features.planes);
  transfer_patches(archive, features.patches);
  transfer_patches(archive, features.patches_around);
  transfer_edges(archive, features.edges);
  archive.size(features.leaf_spacing);
  for (auto& spacing : features.leaf_spacing) archive.number(spacing);
}

}  // namespace

void write_tile_features(const std::string& path, const std::string& key, const TileFeatures& features) {
  std::string content = key;
  BytePacker packer(&content);
  transfer_features(packer, features);
  Header header;
  header.file_size = sizeof(header) + content.size();
  header.checksum = content_checksum(reinterpret_cast<const uint8_t*>(content.data()), content.size());
  header.key_size = static_cast<uint32_t>(key.size());
  AtomicFile file(path);
  file.stream().write(reinterpret_cast<const char*>(&header), sizeof(header));
  file.stream().write(content.data(), static_cast<std::streamsize>(content.size()));
  file.commit();
}

std::optional<TileFeatures> read_tile_features(const std::string& path, const std::string& key) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const MappedFile file(path);
  const std::span<const uint8_t> bytes = file.bytes();
  Header header;
  if (bytes.size() < sizeof(header)) throw Error(fmt::format("{}: truncated: {} bytes", path, bytes.size()));
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.magic != kTileMagic) throw Error(fmt::format("{}: not a file of planes and edges", path));
  if (header.byte_order != Header().byte_order || header.version != kTileFeaturesVersion) return std::nullopt;
  if (header.file_size != bytes.size()) {
    throw Error(fmt::format("{}: {} bytes instead of {}", path, bytes.size(), header.file_size));
  }
  const std::span<const uint8_t> content = bytes.subspan(sizeof(header));
  if (header.key_size > content.size() || content_checksum(content.data(), content.size()) != header.checksum) {
    throw Error(fmt::format("{}: damaged: wrong checksum", path));
  }
  if (std::string(content.begin(), content.begin() + header.key_size) != key) return std::nullopt;
  TileFeatures features;
  ByteUnpacker unpacker(content.subspan(header.key_size));
  transfer_features(unpacker, features);
  if (!unpacker.is_at_end()) throw Error(fmt::format("{}: damaged: its arrays do not end with the file", path));
  return features;
}

}  // namespace cpplus
