#include "cpplus/io/voxel_map_file.h"

#include <cstring>

#include "cpplus/core/random.h"
#include "cpplus/io/index_point_clouds.h"
#include "cpplus/io/map_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_files.h"
#include "cpplus/io/voxel_map_format.h"

namespace cpplus {
namespace {

class VoxelMapFileTest : public FileTest {
 protected:
  /// The bytes of a small map with intensities.
  std::string small_map() const {
    Random random(5);
    PointCloud cloud;
    for (int i = 0; i < 300; ++i) {
      cloud.positions.emplace_back(random.uniform(0, 3), random.uniform(0, 3), random.uniform(0, 1));
      cloud.intensities.push_back(static_cast<float>(i));
    }
    write_point_cloud(path("small.ply"), cloud);
    index_point_clouds({path("small.ply")}, {}, size_t{1} << 20, path("small.vox"));
    return read("small.vox");
  }

  void expect_refused(const std::string& bytes, const std::string& message) const {
    const std::string file = write("bad.vox", bytes);
    EXPECT_ERROR(map_voxel_map_file(file), "bad.vox: " + message);
    EXPECT_ERROR(verify_voxel_map_file(file), "bad.vox: " + message);
  }
};

VoxelMapHeader header_of(const std::string& bytes) {
  VoxelMapHeader header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  return header;
}

std::string with_header(std::string bytes, const VoxelMapHeader& header) {
  std::memcpy(bytes.data(), &header, sizeof(header));
  return bytes;
}

TEST_F(VoxelMapFileTest, SectionsAreAlignedAndInTheFile) {
  const std::string bytes = small_map();
  const VoxelMapHeader header = header_of(bytes);
  EXPECT_EQ(header.file_size, bytes.size());
  EXPECT_EQ(header.num_points, 300u);
  ASSERT_EQ(header.num_sections, 3 + 2 + 5 * 5 + 1u) << "points, roots, five layers of nodes and the leaves";
  uint64_t end = sizeof(header) + header.num_sections * sizeof(VoxelMapSectionEntry);
  for (size_t i = 0; i < header.num_sections; ++i) {
    VoxelMapSectionEntry entry;
    std::memcpy(&entry, bytes.data() + sizeof(header) + i * sizeof(entry), sizeof(entry));
    EXPECT_EQ(entry.offset, aligned_offset(end));
    end = entry.offset + entry.size;
  }
  EXPECT_EQ(aligned_offset(end), bytes.size());
}

TEST_F(VoxelMapFileTest, RefusesWhatIsNoWholeMapOfThisVersion) {
  const std::string bytes = small_map();
  const VoxelMapHeader header = header_of(bytes);
  const auto changed = [&](auto change) {
    VoxelMapHeader other = header;
    change(&other);
    return with_header(bytes, other);
  };
  expect_refused("", "not a voxel map file");
  expect_refused("ply\nformat ascii 1.0\n", "not a voxel map file");
  expect_refused(bytes.substr(0, 40), "truncated: its 40 bytes do not hold the header");
  expect_refused(changed([](auto* h) { h->byte_order = 0x04030201; }),
                 "was written by a machine of another byte order");
  expect_refused(changed([](auto* h) { h->version = 2; }), "has format version 2, this program reads version 1");
  expect_refused(bytes.substr(0, bytes.size() - 1), "truncated: " + std::to_string(bytes.size() - 1) +
                                                        " bytes instead of " + std::to_string(bytes.size()));
  expect_refused(bytes + "x", "too long: ");
  expect_refused(changed([](auto* h) { h->num_sections = 1 << 30; }), "damaged: a table of 1073741824 sections");
  expect_refused(changed([](auto* h) { h->num_points += 1; }), "damaged: header and table have a wrong checksum");
  EXPECT_ERROR(map_voxel_map_file(path("none.vox")), "none.vox: cannot read: No such file");
  std::filesystem::create_directories(path("folder.vox"));
  EXPECT_ERROR(map_voxel_map_file(path("folder.vox")), "folder.vox: is a folder");
}

TEST_F(VoxelMapFileTest, EveryByteOfHeaderAndTableIsChecked) {
  const std::string bytes = small_map();
  const size_t end = sizeof(VoxelMapHeader) + header_of(bytes).num_sections * sizeof(VoxelMapSectionEntry);
  for (size_t i = 0; i < end; ++i) {
    std::string bad = bytes;
    bad[i] = static_cast<char>(bad[i] ^ 0x10);
    EXPECT_THROW(map_voxel_map_file(write("bad.vox", bad)), Error) << "byte " << i;
  }
}

TEST_F(VoxelMapFileTest, VerifyFindsAChangedByteOfEverySection) {
  const std::string bytes = small_map();
  for (size_t i = 0; i < header_of(bytes).num_sections; ++i) {
    VoxelMapSectionEntry entry;
    std::memcpy(&entry, bytes.data() + sizeof(VoxelMapHeader) + i * sizeof(entry), sizeof(entry));
    if (entry.size == 0) continue;  // no voxel of the lowest layers has stored moments
    std::string bad = bytes;
    char& byte = bad[entry.offset + entry.size / 2];
    byte = static_cast<char>(byte ^ 1);
    EXPECT_ERROR(verify_voxel_map_file(write("bad.vox", bad)), "has a wrong checksum");
  }
  EXPECT_NO_THROW(verify_voxel_map_file(write("good.vox", bytes)));
}

TEST_F(VoxelMapFileTest, KeepsItsSizesOfVoxels) {
  small_map();
  index_point_clouds({path("small.ply")}, {4.0, 0.25}, size_t{1} << 20, path("coarse.vox"));
  EXPECT_EQ(read_map(path("coarse.vox"), {}).map.options().leaf_size_m, 0.25) << "by default, those of the file";
  EXPECT_EQ(read_map(path("coarse.vox"), {4.0, 0.25}).map.options().root_size_m, 4.0);
  EXPECT_ERROR(read_map(path("coarse.vox"), {4.0, 0.125}), "coarse.vox: was built with leaf_size_m 0.25, not 0.125");
  EXPECT_ERROR(read_map(path("coarse.vox"), {8.0, 0.25}), "coarse.vox: was built with root_size_m 4, not 8");
}

TEST_F(VoxelMapFileTest, TheCloudOfAMapWithDamagedIndicesIsRefused) {
  std::string bytes = small_map();
  VoxelMapSectionEntry entry;
  std::memcpy(&entry, bytes.data() + sizeof(VoxelMapHeader) + sizeof(entry), sizeof(entry));
  ASSERT_EQ(entry.kind, VoxelMapSection::kInputIndices);
  bytes[entry.offset + 3] = '\x7f';
  EXPECT_ERROR(read_map_cloud(write("bad.vox", bytes)), "bad.vox: damaged: the indices of the map's points");
}

}  // namespace
}  // namespace cpplus
