#include "cpplus/io/potree.h"

#include <nlohmann/json.hpp>

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using Json = nlohmann::json;

class Potree : public FileTest {};

// In steps of 0.1 mm in a cube of 256: the third point is in the cell of the second, farther from its middle.
PointCloud small_cloud() {
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {0.0255f, 0, 0}, {0.0254f, 0, 0.0f}};
  cloud.colors = {{1, 2, 3}, {255, 0, 128}, {0, 0, 0}};
  cloud.intensities = {0.0f, 0.5f, 1.0f};
  cloud.num_views = {4, 300, 0};
  cloud.best_images = {70000, 5, 0};
  cloud.color_spreads = {9, 8, 7};
  return cloud;
}

std::string point(const Eigen::Vector3i& steps, uint16_t intensity, const std::array<uint16_t, 3>& rgb, uint16_t views,
                  uint32_t image, uint8_t spread) {
  return bytes_of(steps.x()) + bytes_of(steps.y()) + bytes_of(steps.z()) + bytes_of(intensity) + bytes_of(rgb[0]) +
         bytes_of(rgb[1]) + bytes_of(rgb[2]) + bytes_of(views) + bytes_of(image) + bytes_of(spread);
}

std::string node(uint8_t type, uint8_t child_mask, uint32_t num_points, uint64_t offset, uint64_t size) {
  return bytes_of(type) + bytes_of(child_mask) + bytes_of(num_points) + bytes_of(offset) + bytes_of(size);
}

TEST_F(Potree, WritesPointsAndHierarchyByteForByte) {
  const PointCloud cloud = small_cloud();
  write_potree(path("out"), "small", cloud, build_point_octree(cloud, {1}));
  EXPECT_EQ(read("out/octree.bin"), point({0, 0, 0}, 0, {257, 514, 771}, 4, 70000, 9) +
                                        point({255, 0, 0}, 32768, {65535, 0, 32896}, 300, 5, 8) +
                                        point({254, 0, 0}, 65535, {0, 0, 0}, 0, 0, 7));
  EXPECT_EQ(read("out/hierarchy.bin"), node(0, 1 << 4, 2, 0, 54) + node(1, 0, 1, 54, 27));
}

TEST_F(Potree, MetadataSaysHowToReadThem) {
  PointCloud cloud = small_cloud();
  cloud.origin = {600000, 5000000, -20};
  write_potree(path("out"), "small", cloud, build_point_octree(cloud, {1}));
  const Json json = Json::parse(read("out/metadata.json"));
  EXPECT_EQ(json["version"], "2.0");
  EXPECT_EQ(json["name"], "small");
  EXPECT_EQ(json["points"], 3);
  EXPECT_EQ(json["encoding"], "DEFAULT");
  EXPECT_EQ(json["hierarchy"], Json::parse(R"({"firstChunkSize": 44, "stepSize": 4, "depth": 1})"));
  EXPECT_EQ(json["scale"], Json::parse("[0.0001, 0.0001, 0.0001]"));
  EXPECT_EQ(json["offset"], json["boundingBox"]["min"]);
  const double edge_m = 128.0 * json["spacing"].get<double>();
  EXPECT_NEAR(edge_m, 0.0256, 1.1e-4);
  for (size_t axis = 0; axis < 3; ++axis) {
    const double low = json["boundingBox"]["min"][axis];
    EXPECT_NEAR(low, cloud.origin[static_cast<Eigen::Index>(axis)], 1.1e-4);
    EXPECT_NEAR(json["boundingBox"]["max"][axis].get<double>() - low, edge_m, 1e-8);
  }
}

TEST_F(Potree, MetadataDescribesTheAttributes) {
  const PointCloud cloud = small_cloud();
  write_potree(path("out"), "small", cloud, build_point_octree(cloud, {1}));
  const Json attributes = Json::parse(read("out/metadata.json"))["attributes"];
  const Json intensity = Json::parse(R"({"name": "intensity", "description": "", "size": 2, "numElements": 1,
      "elementSize": 2, "type": "uint16", "min": [0], "max": [65535], "scale": [1], "offset": [0]})");
  const Json rgb = Json::parse(R"({"name": "rgb", "description": "", "size": 6, "numElements": 3, "elementSize": 2,
      "type": "uint16", "min": [0, 0, 0], "max": [65535, 514, 32896], "scale": [1, 1, 1], "offset": [0, 0, 0]})");
  ASSERT_EQ(attributes.size(), 6u);
  EXPECT_EQ(attributes[0]["name"], "position");
  EXPECT_EQ(attributes[0]["type"], "int32");
  EXPECT_EQ(attributes[0]["size"], 12);
  EXPECT_EQ(attributes[0]["min"], Json::parse("[0.0, 0.0, 0.0]"));
  EXPECT_NEAR(attributes[0]["max"][0].get<double>(), 0.0255, 1e-9);
  EXPECT_EQ(attributes[0]["max"][1], 0.0);
  EXPECT_EQ(attributes[1], intensity);
  EXPECT_EQ(attributes[2], rgb);
  EXPECT_EQ(attributes[3]["name"], "num_views");
  EXPECT_EQ(attributes[4]["name"], "best_image");
  EXPECT_EQ(attributes[4]["type"], "uint32");
  EXPECT_EQ(attributes[5]["name"], "color_spread");
  EXPECT_EQ(attributes[5]["type"], "uint8");
}

TEST_F(Potree, CloudWithoutAttributesIsPositions) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}};
  write_potree(path("out"), "bare", cloud, build_point_octree(cloud, {}));
  EXPECT_EQ(read("out/octree.bin").size(), 12u);
  EXPECT_EQ(read("out/hierarchy.bin"), node(1, 0, 1, 0, 12));
  EXPECT_EQ(Json::parse(read("out/metadata.json"))["attributes"].size(), 1u);
}

TEST_F(Potree, NamesWhatCannotBeWritten) {
  const PointCloud cloud = small_cloud();
  write("file", "");
  EXPECT_ERROR(write_potree(path("file"), "small", cloud, build_point_octree(cloud, {1})), path("file/octree.bin"));
}

}  // namespace
}  // namespace cpplus
