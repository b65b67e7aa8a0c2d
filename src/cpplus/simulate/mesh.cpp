#include "cpplus/simulate/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cpplus {
namespace {

using Eigen::Vector3d;

/// Normal of a planar polygon by Newell's sum, which does not mind collinear corners.
Vector3d polygon_normal(const std::vector<Vector3d>& corners) {
  Vector3d sum = Vector3d::Zero();
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    sum += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
  }
  return sum.normalized();
}

}  // namespace

Rigid3 placed_at(const Vector3d& position, double yaw_rad) {
  return Rigid3(Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ())), position);
}

void MeshBuilder::add_face(const std::vector<Vector3d>& corners, const Vector3d& uv_origin, const Vector3d& u_axis,
                           uint32_t material) {
  const Vector3d normal = polygon_normal(corners);
  const auto first = static_cast<int>(mesh_->vertices.size());
  MeshFace face;
  for (const Vector3d& corner : corners) face.corners.push_back((mesh_from_local_ * corner).cast<float>());
  face.normal = (mesh_from_local_.rotation * normal).cast<float>();
  face.uv_origin = (mesh_from_local_ * uv_origin).cast<float>();
  face.u_axis = (mesh_from_local_.rotation * u_axis).cast<float>();
  face.v_axis = (mesh_from_local_.rotation * normal.cross(u_axis)).cast<float>();
  face.material = material;
  face.object = object_;
  face.has_edges = has_edges_;
  for (const auto& corner : face.corners) mesh_->vertices.push_back(corner);
  for (int i = 1; i + 1 < static_cast<int>(corners.size()); ++i) {
    mesh_->triangles.emplace_back(first, first + i, first + i + 1);
    mesh_->triangle_faces.push_back(static_cast<uint32_t>(mesh_->faces.size()));
  }
  mesh_->faces.push_back(std::move(face));
}

void MeshBuilder::add_polygon(const std::vector<Vector3d>& corners, uint32_t material) {
  const Vector3d normal = polygon_normal(corners);
  // u is horizontal where the face is not, so that bricks lie and text reads level.
  const Vector3d reference = std::abs(normal.z()) > 0.7 ? Vector3d::UnitY() : Vector3d::UnitZ();
  add_face(corners, Vector3d::Zero(), reference.cross(normal).normalized(), material);
}

void MeshBuilder::add_quad(const Vector3d& origin, const Vector3d& u, const Vector3d& v, uint32_t material) {
  add_face({origin, origin + u, origin + u + v, origin + v}, origin, u.normalized(), material);
}

void MeshBuilder::add_box(const Vector3d& low, const Vector3d& high, uint32_t material) {
  for (int axis = 0; axis < 3; ++axis) {
    const int b = (axis + 1) % 3;
    const int c = (axis + 2) % 3;
    // u runs along the longer side (grain of boards), except that it stays horizontal on upright faces of walls.
    const bool u_is_b = axis == 2 ? high[b] - low[b] >= high[c] - low[c] : b != 2;
    const bool upright_post = axis != 2 && (high.z() - low.z()) > 4.0 * (high[b == 2 ? c : b] - low[b == 2 ? c : b]) &&
                              high.z() - low.z() < 2.5;
    for (const bool is_high : {false, true}) {
      Vector3d p = low;
      p[axis] = is_high ? high[axis] : low[axis];
      Vector3d step_b = Vector3d::Zero();
      Vector3d step_c = Vector3d::Zero();
      step_b[b] = high[b] - low[b];
      step_c[c] = high[c] - low[c];
      std::vector<Vector3d> corners = {p, p + step_b, p + step_b + step_c, p + step_c};
      if (!is_high) std::reverse(corners.begin(), corners.end());
      const Vector3d u = (u_is_b != upright_post) ? step_b.normalized() : step_c.normalized();
      Vector3d uv_origin = Vector3d::Zero();
      uv_origin[axis] = p[axis];
      add_face(corners, uv_origin, u, material);
    }
  }
}

void MeshBuilder::add_prism(const std::vector<Eigen::Vector2d>& profile_xz, double y_low, double y_high,
                            uint32_t material) {
  std::vector<Vector3d> front;
  std::vector<Vector3d> back;
  for (const auto& p : profile_xz) {
    front.emplace_back(p.x(), y_low, p.y());
    back.emplace_back(p.x(), y_high, p.y());
  }
  const size_t n = profile_xz.size();
  for (size_t i = 0; i < n; ++i) {
    const size_t j = (i + 1) % n;
    add_polygon({front[i], back[i], back[j], front[j]}, material);
  }
  add_polygon(front, material);
  std::reverse(back.begin(), back.end());
  add_polygon(back, material);
}

void MeshBuilder::add_cylinder(const Vector3d& base, const Vector3d& top, double base_radius, double top_radius,
                               uint32_t material, int num_sides) {
  const Vector3d axis = (top - base).normalized();
  const Vector3d helper = std::abs(axis.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX();
  const Vector3d x = helper.cross(axis).normalized();
  const Vector3d y = axis.cross(x);
  std::vector<Vector3d> lower;
  std::vector<Vector3d> upper;
  for (int i = 0; i < num_sides; ++i) {
    const double angle = 2.0 * M_PI * i / num_sides;
    const Vector3d radial = std::cos(angle) * x + std::sin(angle) * y;
    lower.push_back(base + base_radius * radial);
    upper.push_back(top + top_radius * radial);
  }
  for (int i = 0; i < num_sides; ++i) {
    const int j = (i + 1) % num_sides;
    add_polygon({lower[i], lower[j], upper[j], upper[i]}, material);
  }
  add_polygon(upper, material);
  std::reverse(lower.begin(), lower.end());
  add_polygon(lower, material);
}

void MeshBuilder::add_sphere(const Vector3d& center, const Vector3d& radii, uint32_t material) {
  constexpr int kRows = 8;
  constexpr int kColumns = 12;
  const auto at = [&](int row, int column) -> Vector3d {
    const double latitude = M_PI * (static_cast<double>(row) / kRows - 0.5);
    const double longitude = 2.0 * M_PI * column / kColumns;
    const Vector3d unit(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                        std::sin(latitude));
    return center + radii.cwiseProduct(unit);
  };
  const bool had_edges = has_edges_;
  has_edges_ = false;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Vector3d a = at(row, column);
      const Vector3d b = at(row, column + 1);
      const Vector3d c = at(row + 1, column + 1);
      const Vector3d d = at(row + 1, column);
      if (row > 0) add_polygon({a, b, c}, material);
      if (row + 1 < kRows) add_polygon({a, c, d}, material);
    }
  }
  has_edges_ = had_edges;
}

}  // namespace cpplus
