#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <nlohmann/json.hpp>
#include <random>

#include "cpplus/core/parallel.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_files.h"
#include "cpplus/pipeline/export_command.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct PotreePoint {
  Eigen::Vector3d position;
  std::map<std::string, std::vector<uint32_t>> values;
};

template <typename T>
T number_at(const std::string& bytes, size_t offset) {
  T value;
  EXPECT_LE(offset + sizeof(T), bytes.size());
  std::memcpy(&value, bytes.data() + std::min(offset, bytes.size() - sizeof(T)), sizeof(T));
  return value;
}

/// Reads a Potree 2.0 folder by what its viewers do: the nodes of the first chunk breadth-first, the cube of a child
/// from its octant, attributes one after the other by their sizes.
class PotreeReader {
 public:
  explicit PotreeReader(const fs::path& folder)
      : metadata(Json::parse(read(folder / "metadata.json"))),
        octree_(read(folder / "octree.bin")),
        hierarchy_(read(folder / "hierarchy.bin")) {
    EXPECT_EQ(metadata["encoding"], "DEFAULT");
    EXPECT_EQ(metadata["hierarchy"]["firstChunkSize"], hierarchy_.size());
    read_nodes();
  }

  Json metadata;
  std::vector<PotreePoint> points;
  size_t num_nodes = 0;
  size_t num_root_points = 0;

 private:
  struct Node {
    int level = 0;
    Eigen::Vector3d low, high;
  };

  static std::string read(const fs::path& path) {
    std::ostringstream bytes;
    bytes << std::ifstream(path, std::ios::binary).rdbuf();
    return bytes.str();
  }

  static Eigen::Vector3d vector(const Json& json) {
    return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
  }

  void read_nodes() {
    std::deque<Node> nodes = {{0, vector(metadata["boundingBox"]["min"]), vector(metadata["boundingBox"]["max"])}};
    int depth = 0;
    uint64_t next_byte = 0;
    for (; !nodes.empty(); ++num_nodes) {
      const Node node = nodes.front();
      nodes.pop_front();
      depth = std::max(depth, node.level);
      const size_t at = 22 * num_nodes;
      const uint8_t type = number_at<uint8_t>(hierarchy_, at), mask = number_at<uint8_t>(hierarchy_, at + 1);
      EXPECT_EQ(type, mask == 0 ? 1 : 0);
      EXPECT_EQ(number_at<uint64_t>(hierarchy_, at + 6), next_byte);
      next_byte += number_at<uint64_t>(hierarchy_, at + 14);
      read_points(node, number_at<uint32_t>(hierarchy_, at + 2), number_at<uint64_t>(hierarchy_, at + 6));
      EXPECT_EQ(metadata_bytes_per_point() * points.size(), next_byte);
      if (num_nodes == 0) num_root_points = points.size();
      for (int octant = 0; octant < 8; ++octant) {
        if ((mask & 1 << octant) != 0) nodes.push_back(octant_of(node, octant));
      }
    }
    EXPECT_EQ(num_nodes * 22, hierarchy_.size());
    EXPECT_EQ(next_byte, octree_.size());
    EXPECT_EQ(metadata["hierarchy"]["depth"], depth);
    EXPECT_EQ(metadata["points"], points.size());
  }

  size_t metadata_bytes_per_point() const {
    size_t size = 0;
    for (const Json& attribute : metadata["attributes"]) size += attribute["size"].get<size_t>();
    return size;
  }

  static Node octant_of(const Node& node, int octant) {
    Node child{node.level + 1, node.low, node.high};
    for (int axis = 0; axis < 3; ++axis) {
      const bool upper = (octant >> (2 - axis) & 1) != 0;
      (upper ? child.low : child.high)[axis] = 0.5 * (node.low[axis] + node.high[axis]);
    }
    return child;
  }

  void read_points(const Node& node, uint32_t num_points, uint64_t offset) {
    for (uint32_t i = 0; i < num_points; ++i) {
      PotreePoint point;
      for (const Json& attribute : metadata["attributes"]) {
        const std::string name = attribute["name"];
        const size_t size = attribute["elementSize"];
        for (size_t element = 0; element < attribute["numElements"]; ++element, offset += size) {
          if (name == "position") {
            point.position[static_cast<Eigen::Index>(element)] =
                number_at<int32_t>(octree_, offset) * metadata["scale"][element].get<double>() +
                metadata["offset"][element].get<double>();
            continue;
          }
          uint32_t value = 0;
          std::memcpy(&value, octree_.data() + offset, size);
          EXPECT_GE(value, attribute["min"][element]) << name;
          EXPECT_LE(value, attribute["max"][element]) << name;
          point.values[name].push_back(value);
        }
      }
      constexpr double kRounding = 1e-8;
      EXPECT_TRUE((point.position.array() >= node.low.array() - kRounding).all() &&
                  (point.position.array() <= node.high.array() + kRounding).all())
          << point.position.transpose();
      points.push_back(std::move(point));
    }
  }

  std::string octree_;
  std::string hierarchy_;
};

/// Two walls and a floor at UTM coordinates, coloured by place; no image sees every third point.
PointCloud make_map() {
  PointCloud cloud;
  cloud.origin = {600000, 5000000, 100};
  std::mt19937 random(3);
  std::uniform_real_distribution<float> along(0.0f, 10.0f);
  for (uint32_t i = 0; i < 45000; ++i) {
    Eigen::Vector3f x(along(random), along(random), along(random));
    x[static_cast<Eigen::Index>(i % 3)] = 0.0f;
    cloud.positions.push_back(x);
    cloud.colors.push_back({static_cast<uint8_t>(x.x() * 25), static_cast<uint8_t>(x.y() * 25), 7});
    cloud.num_views.push_back(i % 3 == 0 ? 0 : 5);
    cloud.best_images.push_back(i);
    cloud.color_spreads.push_back(3);
  }
  return cloud;
}

class ExportPotree : public FileTest {
 protected:
  ExportCommandOptions options(const std::string& map, const std::string& out) const {
    ExportCommandOptions options;
    options.format = "potree";
    options.map = path(map);
    options.out = path(out);
    return options;
  }
};

TEST_F(ExportPotree, HoldsEveryPointOfTheMapOnceWithItsColor) {
  write_point_cloud(path("coloured.ply"), make_map());
  const PointCloud cloud = read_point_cloud(path("coloured.ply"));
  ASSERT_EQ(cloud.size(), 45000u);
  EXPECT_EQ(run_export(options("coloured.ply", "out")).num_points, cloud.size());
  PotreeReader read(path("out"));
  EXPECT_EQ(read.metadata["name"], "coloured");
  EXPECT_GT(read.num_nodes, 5u);
  EXPECT_LT(read.num_root_points, cloud.size());
  ASSERT_EQ(read.points.size(), cloud.size());
  // best_image is the place in the cloud.
  std::sort(read.points.begin(), read.points.end(),
            [](PotreePoint& a, PotreePoint& b) { return a.values["best_image"] < b.values["best_image"]; });
  for (size_t i = 0; i < cloud.size(); ++i) {
    auto& values = read.points[i].values;
    ASSERT_EQ(values["best_image"], std::vector<uint32_t>{static_cast<uint32_t>(i)});
    EXPECT_LT((read.points[i].position - cloud.point(i)).cwiseAbs().maxCoeff(), 0.5e-4 + 1e-8);
    EXPECT_EQ(values["num_views"], std::vector<uint32_t>{cloud.num_views[i]});
    const Rgb shown = i % 3 == 0 ? Rgb{130, 130, 130} : cloud.colors[i];
    EXPECT_EQ(values["rgb"], (std::vector<uint32_t>{shown[0] * 257u, shown[1] * 257u, shown[2] * 257u}));
  }
}

TEST_F(ExportPotree, MapWithoutColorsIsGreyByIntensity) {
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, 1, 1}, {1, 0, 0}};
  cloud.intensities = {10, 20, 20};
  write_point_cloud(path("map.pcd"), cloud);
  run_export(options("map.pcd", "out"));
  PotreeReader read(path("out"));
  ASSERT_EQ(read.points.size(), 3u);
  EXPECT_EQ(read.points[0].values["intensity"], std::vector<uint32_t>{10});
  EXPECT_EQ(read.points[1].values["intensity"], std::vector<uint32_t>{20});
  EXPECT_EQ(read.points[0].values["rgb"], std::vector<uint32_t>(3, 60 * 257));
  EXPECT_EQ(read.points[1].values["rgb"], std::vector<uint32_t>(3, 190 * 257));
}

TEST_F(ExportPotree, LocalOriginIsTheMiddleOfTheCameras) {
  PointCloud cloud;
  cloud.origin = {600000, 5000000, 100};
  cloud.positions = {{0, 0, 0}, {1, 2, 3}};
  write_point_cloud(path("map.ply"), cloud);
  SparseModel model;
  model.cameras.emplace(1, Camera(CameraModel::kPinhole, 64, 48, {50, 50, 32, 24}));
  PosedImage image;
  image.id = 1;
  image.camera_id = 1;
  image.name = "a.png";
  image.camera_from_map.translation = {-600000.0, -5000000.0, -101.0};
  model.images = {image};
  write_sparse_model_text(path("model"), model);
  ExportCommandOptions local = options("map.ply", "out");
  local.local_origin = true;
  EXPECT_THROW(run_export(local), UsageError);
  local.poses = path("model");
  run_export(local);
  EXPECT_EQ(read("out/origin.txt"), "600000 5000000 101\n");
  const PotreeReader read(path("out"));
  EXPECT_LT((read.points[1].position - Eigen::Vector3d(1, 2, 2)).cwiseAbs().maxCoeff(), 0.51e-4);
}

TEST_F(ExportPotree, DoesNotDependOnThreads) {
  write_point_cloud(path("coloured.ply"), make_map());
  for (const int threads : {1, 4}) {
    set_num_threads(threads);
    run_export(options("coloured.ply", std::to_string(threads)));
  }
  set_num_threads(0);
  for (const char* name : {"/octree.bin", "/hierarchy.bin", "/metadata.json"}) {
    EXPECT_TRUE(read("1" + std::string(name)) == read("4" + std::string(name))) << name;
  }
}

TEST_F(ExportPotree, LeavesNothingWhereTheMapCannotBeRead) {
  write("map.ply", "no cloud");
  EXPECT_ERROR(run_export(options("map.ply", "out")), path("map.ply"));
  EXPECT_EQ(num_files(), 1u);
}

}  // namespace
}  // namespace cpplus
