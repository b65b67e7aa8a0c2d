#include "cpplus/io/potree.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "cpplus/core/progress.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/byte_writer.h"
#include "cpplus/io/intensity_16_bits.h"

namespace cpplus {
namespace {

using Json = nlohmann::ordered_json;

enum NodeType : uint8_t { kInner = 0, kLeaf = 1 };

constexpr uint16_t kToSixteenBits = 257;
constexpr int kChunkLevels = 4;  // what other chunks would hold; there are none

/// Numbers that each point has besides its position.
struct Attribute {
  std::string name;
  std::string type;
  size_t element_size = 0;
  size_t num_elements = 1;
  std::function<uint32_t(size_t point, size_t element)> value;
};

template <typename T>
Attribute attribute_of(const std::string& name, const std::string& type, const std::vector<T>& values) {
  return {name, type, sizeof(T), 1, [&values](size_t point, size_t) { return static_cast<uint32_t>(values[point]); }};
}

std::vector<Attribute> attributes_of(const PointCloud& cloud) {
  std::vector<Attribute> attributes;
  if (!cloud.intensities.empty()) {
    IntensityFactor factor;
    factor.add(cloud.intensities);
    attributes.push_back({"intensity", "uint16", 2, 1, [&cloud, factor = factor.value()](size_t point, size_t) {
                            return uint32_t{to_16_bits(cloud.intensities[point] * factor)};
                          }});
  }
  if (!cloud.colors.empty()) {
    attributes.push_back({"rgb", "uint16", 2, 3, [&cloud](size_t point, size_t channel) {
                            return uint32_t{cloud.colors[point][channel]} * kToSixteenBits;
                          }});
  }
  if (!cloud.num_views.empty()) attributes.push_back(attribute_of("num_views", "uint16", cloud.num_views));
  if (!cloud.best_images.empty()) attributes.push_back(attribute_of("best_image", "uint32", cloud.best_images));
  if (!cloud.color_spreads.empty()) attributes.push_back(attribute_of("color_spread", "uint8", cloud.color_spreads));
  return attributes;
}

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json attribute_json(const std::string& name, const std::string& type, size_t element_size, const Json& min,
                    const Json& max) {
  const size_t num_elements = min.size();
  return {{"name", name},
          {"description", ""},
          {"size", element_size * num_elements},
          {"numElements", num_elements},
          {"elementSize", element_size},
          {"type", type},
          {"min", min},
          {"max", max},
          {"scale", std::vector<int>(num_elements, 1)},
          {"offset", std::vector<int>(num_elements, 0)}};
}

Json position_json(const PointOctree& octree) {
  Eigen::Vector3i min = octree.steps.front(), max = min;
  for (const Eigen::Vector3i& steps : octree.steps) {
    min = min.cwiseMin(steps);
    max = max.cwiseMax(steps);
  }
  const auto in_map = [&](const Eigen::Vector3i& steps) {
    return vector_json(octree.corner_in_map + octree.step_m * steps.cast<double>());
  };
  return attribute_json("position", "int32", sizeof(int32_t), in_map(min), in_map(max));
}

Json json_of(const Attribute& attribute, size_t num_points) {
  std::vector<uint32_t> min(attribute.num_elements, std::numeric_limits<uint32_t>::max());
  std::vector<uint32_t> max(attribute.num_elements, 0);
  for (size_t i = 0; i < num_points; ++i) {
    for (size_t element = 0; element < attribute.num_elements; ++element) {
      min[element] = std::min(min[element], attribute.value(i, element));
      max[element] = std::max(max[element], attribute.value(i, element));
    }
  }
  return attribute_json(attribute.name, attribute.type, attribute.element_size, min, max);
}

void write_points(const std::string& path, const PointOctree& octree, const std::vector<Attribute>& attributes) {
  AtomicFile file(path);
  ByteWriter writer(&file.stream());
  Progress progress("write octree", octree.nodes.size());
  for (const PointOctreeNode& node : octree.nodes) {
    for (uint32_t i = node.first; i < node.first + node.num_points; ++i) {
      const uint32_t point = octree.order[i];
      for (int axis = 0; axis < 3; ++axis) writer.put(int32_t{octree.steps[point][axis]});
      for (const Attribute& attribute : attributes) {
        for (size_t element = 0; element < attribute.num_elements; ++element) {
          const uint32_t value = attribute.value(point, element);  // little-endian: its lower bytes come first
          writer.put_bytes(reinterpret_cast<const char*>(&value), attribute.element_size);
        }
      }
    }
    progress.advance();
  }
  writer.flush();
  file.commit();
}

void write_hierarchy(const std::string& path, const PointOctree& octree, size_t bytes_per_point) {
  AtomicFile file(path);
  ByteWriter writer(&file.stream());
  uint64_t offset = 0;
  for (const PointOctreeNode& node : octree.nodes) {
    const uint64_t size = uint64_t{node.num_points} * bytes_per_point;
    writer.put<uint8_t>(node.child_mask == 0 ? kLeaf : kInner);
    writer.put<uint8_t>(node.child_mask);
    writer.put<uint32_t>(node.num_points);
    writer.put<uint64_t>(offset);
    writer.put<uint64_t>(size);
    offset += size;
  }
  writer.flush();
  file.commit();
}

constexpr size_t kHierarchyNodeSize = 22;

}  // namespace

void write_potree(const std::string& folder, const std::string& name, const PointCloud& cloud,
                  const PointOctree& octree) {
  const std::vector<Attribute> attributes = attributes_of(cloud);
  size_t bytes_per_point = 3 * sizeof(int32_t);
  Json attributes_json = {position_json(octree)};
  for (const Attribute& attribute : attributes) {
    bytes_per_point += attribute.element_size * attribute.num_elements;
    attributes_json.push_back(json_of(attribute, cloud.size()));
  }
  write_points(folder + "/octree.bin", octree, attributes);
  write_hierarchy(folder + "/hierarchy.bin", octree, bytes_per_point);
  Json metadata;
  metadata["version"] = "2.0";
  metadata["name"] = name;
  metadata["description"] = "";
  metadata["points"] = cloud.size();
  metadata["projection"] = "";
  metadata["hierarchy"] = {{"firstChunkSize", octree.nodes.size() * kHierarchyNodeSize},
                           {"stepSize", kChunkLevels},
                           {"depth", octree.nodes.back().level}};
  metadata["offset"] = vector_json(octree.corner_in_map);
  metadata["scale"] = std::vector<double>(3, octree.step_m);
  metadata["spacing"] = octree.edge_m() / point_octree_cells;
  const Eigen::Vector3d edges = Eigen::Vector3d::Constant(octree.edge_m());
  metadata["boundingBox"] = {{"min", vector_json(octree.corner_in_map)},
                             {"max", vector_json(octree.corner_in_map + edges)}};
  metadata["encoding"] = "DEFAULT";
  metadata["attributes"] = std::move(attributes_json);
  write_text_file(folder + "/metadata.json", metadata.dump(1) + "\n");
}

}  // namespace cpplus
