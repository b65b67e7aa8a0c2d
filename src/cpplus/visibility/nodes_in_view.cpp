#include "cpplus/visibility/nodes_in_view.h"

#include <array>
#include <cmath>

#include "cpplus/cloud/select_roots.h"
#include "cpplus/geometry/tangent_box.h"

namespace cpplus {
namespace {

// Nodes of one layer with their centres in the camera's frame.
struct Nodes {
  std::vector<uint32_t> index;
  std::vector<float> x, y, z;

  size_t size() const { return index.size(); }
  Eigen::Vector3f center(size_t i) const { return {x[i], y[i], z[i]}; }
  void add(uint32_t node, const Eigen::Vector3f& center_in_camera) {
    index.push_back(node);
    x.push_back(center_in_camera.x());
    y.push_back(center_in_camera.y());
    z.push_back(center_in_camera.z());
  }
};

class Descent {
 public:
  Descent(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map, double max_distance_m,
          double margin_m, const HiddenRanges& hidden)
      : map_(map),
        camera_(camera),
        rotation_(camera_from_map.rotation.toRotationMatrix().cast<float>()),
        box_(tangent_box(camera)),
        max_distance_m_(static_cast<float>(max_distance_m)),
        margin_m_(static_cast<float>(margin_m)),
        hidden_(hidden) {
    for (const uint32_t root : select_roots(map, camera, camera_from_map, max_distance_m)) {
      nodes_.add(root, (camera_from_map * map.center(0, root)).cast<float>());
    }
  }

  std::vector<uint32_t> run(int layer) {
    for (int l = 0; l < layer; ++l) {
      keep_visible(l);
      expand(l);
    }
    keep_visible(layer);
    return std::move(nodes_.index);
  }

 private:
  void keep_visible(int layer) {
    const float radius_m = static_cast<float>(0.5 * std::sqrt(3.0) * map_.voxel_size(layer)) + margin_m_;
    columns_.resize(nodes_.size());
    rows_.resize(nodes_.size());
    camera_.project(nodes_.size(), nodes_.x.data(), nodes_.y.data(), nodes_.z.data(), columns_.data(), rows_.data());
    Nodes kept;
    for (size_t i = 0; i < nodes_.size(); ++i) {
      const Eigen::Vector3f center = nodes_.center(i);
      const float range = center.norm();
      if (box_.excludes(center, radius_m) || range > max_distance_m_ + radius_m) continue;
      if (hidden_.hides({columns_[i], rows_[i]}, range, radius_m)) continue;
      kept.add(nodes_.index[i], center);
    }
    nodes_ = std::move(kept);
  }

  // The children of the nodes, in the order of their octants.
  void expand(int layer) {
    std::array<Eigen::Vector3f, 8> to_octant;
    const float quarter = static_cast<float>(0.25 * map_.voxel_size(layer));
    for (int octant = 0; octant < 8; ++octant) {
      const Eigen::Array3f upper(static_cast<float>(octant & 1), static_cast<float>(octant >> 1 & 1),
                                 static_cast<float>(octant >> 2));
      to_octant[static_cast<size_t>(octant)] = rotation_ * (quarter * (2.0f * upper - 1.0f)).matrix();
    }
    Nodes children;
    const VoxelMapLayer& parents = map_.arrays().layers[static_cast<size_t>(layer)];
    for (size_t i = 0; i < nodes_.size(); ++i) {
      uint32_t child = parents.first[nodes_.index[i]];
      for (size_t octant = 0; octant < 8; ++octant) {
        if (!(parents.child_mask[nodes_.index[i]] >> octant & 1)) continue;
        children.add(child++, nodes_.center(i) + to_octant[octant]);
      }
    }
    nodes_ = std::move(children);
  }

  const VoxelMap& map_;
  const Camera& camera_;
  Eigen::Matrix3f rotation_;
  TangentBox box_;
  float max_distance_m_;
  float margin_m_;
  const HiddenRanges& hidden_;
  Nodes nodes_;
  std::vector<float> columns_, rows_;
};

}  // namespace

std::vector<uint32_t> nodes_in_view(const VoxelMap& map, int layer, const Camera& camera, const Rigid3& camera_from_map,
                                    double max_distance_m, double margin_m, const HiddenRanges& hidden) {
  if (map.num_layers() == 0) return {};
  return Descent(map, camera, camera_from_map, max_distance_m, margin_m, hidden).run(layer);
}

}  // namespace cpplus
