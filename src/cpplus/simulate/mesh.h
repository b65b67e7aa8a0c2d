#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// A planar convex polygon, seen from its front: corners run counter-clockwise around the outward normal.
struct MeshFace {
  std::vector<Eigen::Vector3f> corners;  // metres
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
  Eigen::Vector3f uv_origin = Eigen::Vector3f::Zero();
  Eigen::Vector3f u_axis = Eigen::Vector3f::UnitX();  // unit
  Eigen::Vector3f v_axis = Eigen::Vector3f::UnitY();  // unit
  uint32_t material = 0;
  uint32_t object = 0;
  bool has_edges = true;  // false for leaves and round things: their facets' borders are no edges of the scene

  Eigen::Vector2f uv(const Eigen::Vector3f& point) const {
    return {u_axis.dot(point - uv_origin), v_axis.dot(point - uv_origin)};
  }
};

/// Faces and their triangulation. Solids are closed and may touch or pass through each other.
struct Mesh {
  std::vector<MeshFace> faces;
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Vector3i> triangles;
  std::vector<uint32_t> triangle_faces;
};

/// Appends solids to a mesh. Coordinates are in the local frame, which `set_frame` places in the mesh's frame.
class MeshBuilder {
 public:
  explicit MeshBuilder(Mesh* mesh) : mesh_(mesh) {}

  void set_frame(const Rigid3& mesh_from_local) { mesh_from_local_ = mesh_from_local; }
  const Rigid3& frame() const { return mesh_from_local_; }
  void set_object(uint32_t object) { object_ = object; }
  void set_has_edges(bool has_edges) { has_edges_ = has_edges; }

  /// Convex, planar, counter-clockwise from the front; (u, v) from the local axes nearest to the plane.
  void add_polygon(const std::vector<Eigen::Vector3d>& corners, uint32_t material);
  /// Parallelogram origin, origin + u, origin + u + v, origin + v with the normal u x v. (u, v) starts at `origin`.
  void add_quad(const Eigen::Vector3d& origin, const Eigen::Vector3d& u, const Eigen::Vector3d& v, uint32_t material);
  void add_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, uint32_t material);
  /// A right prism: the convex profile in (x, z), counter-clockwise seen from -y, from y = y_low to y = y_high.
  void add_prism(const std::vector<Eigen::Vector2d>& profile_xz, double y_low, double y_high, uint32_t material);
  /// A cylinder or cone frustum from `base` to `top`.
  void add_cylinder(const Eigen::Vector3d& base, const Eigen::Vector3d& top, double base_radius, double top_radius,
                    uint32_t material, int num_sides = 24);
  void add_sphere(const Eigen::Vector3d& center, const Eigen::Vector3d& radii, uint32_t material);

 private:
  void add_face(const std::vector<Eigen::Vector3d>& corners, const Eigen::Vector3d& uv_origin,
                const Eigen::Vector3d& u_axis, uint32_t material);

  Mesh* mesh_;
  Rigid3 mesh_from_local_;
  uint32_t object_ = 0;
  bool has_edges_ = true;
};

/// Frame at (x, y, z) turned by yaw about z.
Rigid3 placed_at(const Eigen::Vector3d& position, double yaw_rad);

}  // namespace cpplus
