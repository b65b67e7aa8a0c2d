#pragma once

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/cloud/plane_buffer.h"
#include "cpplus/core/random.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/image_edge.h"
#include "cpplus/geometry/image_pose.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/edge_samples.h"

namespace cpplus {

struct Box {
  Eigen::Vector3d low;
  Eigen::Vector3d high;
  double side(int axis, int which) const { return which == 0 ? low(axis) : high(axis); }
};

/// A room seen from inside with boxes in it, all parallel to the axes of the map (z up): its lines, its planes and what
/// hides what are known exactly. Planes: six of the shell, then six of each box, in order of axis and side.
struct TestRoom {
  std::optional<Box> shell;
  std::vector<Box> boxes;
  std::vector<MapEdge> edges;
  std::vector<MapPlane> planes;
};

inline Eigen::Vector3d unit(int axis, double sign = 1.0) { return sign * Eigen::Vector3d::Unit(axis); }

inline void add_planes(const Box& box, double facing, std::vector<MapPlane>* planes) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int which = 0; which < 2; ++which) {
      MapPlane plane;
      plane.normal = unit(axis, facing * (which == 0 ? -1.0 : 1.0));
      plane.centroid = 0.5 * (box.low + box.high);
      plane.centroid(axis) = box.side(axis, which);
      plane.num_points = 10000;
      planes->push_back(plane);
    }
  }
}

/// The twelve edges of a box. facing: 1 = seen from outside, -1 = from inside. A box that stands on `floor_z` has
/// contact lines there instead.
inline void add_edges(const Box& box, double facing, double floor_z, std::vector<MapEdge>* edges) {
  for (int along = 0; along < 3; ++along) {
    const int i = along == 0 ? 1 : 0;
    const int j = along == 2 ? 1 : 2;
    for (int corner = 0; corner < 4; ++corner) {
      const int side_i = corner & 1;
      const int side_j = corner >> 1;
      const double sign_i = side_i == 0 ? -1.0 : 1.0;
      const double sign_j = side_j == 0 ? -1.0 : 1.0;
      MapEdge edge;
      edge.start(i) = edge.end(i) = box.side(i, side_i);
      edge.start(j) = edge.end(j) = box.side(j, side_j);
      edge.start(along) = box.low(along);
      edge.end(along) = box.high(along);
      edge.normal_a = unit(i, facing * sign_i);
      edge.inward_a = unit(j, -sign_j);
      edge.normal_b = unit(j, facing * sign_j);
      edge.inward_b = unit(i, -sign_i);
      if (facing > 0 && j == 2 && side_j == 0 && box.low.z() == floor_z) {
        edge.normal_b = unit(2);
        edge.inward_b = unit(i, sign_i);
      }
      edge.covariance = 4e-6 * (Eigen::Matrix3d::Identity() - unit(along) * unit(along).transpose());
      edge.group = static_cast<uint32_t>(edges->size());
      edges->push_back(edge);
    }
  }
}

inline TestRoom make_room(const std::optional<Box>& shell, const std::vector<Box>& boxes) {
  TestRoom room;
  room.shell = shell;
  room.boxes = boxes;
  // Without a shell its planes are left out: indices then start with the boxes.
  if (shell) {
    add_planes(*shell, -1.0, &room.planes);
    add_edges(*shell, -1.0, 0.0, &room.edges);
  }
  for (const Box& box : boxes) {
    add_planes(box, 1.0, &room.planes);
    add_edges(box, 1.0, shell ? shell->low.z() : -1e9, &room.edges);
  }
  return room;
}

/// 6 x 5 x 3 m with six boxes: three on the floor, a shelf, a beam and a lamp.
inline TestRoom furnished_room() {
  const std::vector<Box> boxes = {{{3.6, 2.0, 0.0}, {4.3, 2.9, 0.8}}, {{4.9, 3.6, 0.0}, {6.0, 5.0, 1.9}},
                                  {{1.2, 2.2, 0.0}, {1.9, 2.8, 1.0}}, {{2.0, 4.5, 1.3}, {3.4, 5.0, 1.7}},
                                  {{4.6, 0.0, 2.6}, {5.0, 5.0, 3.0}}, {{2.2, 1.2, 1.9}, {2.6, 1.6, 2.2}}};
  return make_room(Box{{0, 0, 0}, {6, 5, 3}}, boxes);
}

/// Range of the box along the ray (entry from outside, exit from inside) and the face met: 2 * axis + side.
inline std::optional<std::pair<double, int>> cast_box(const Box& box, const Eigen::Vector3d& origin,
                                                      const Eigen::Vector3d& bearing, bool from_inside) {
  double enter = 0.0;
  double exit = std::numeric_limits<double>::max();
  int enter_face = -1;
  int exit_face = -1;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(bearing(axis)) < 1e-12) {
      if (origin(axis) < box.low(axis) || origin(axis) > box.high(axis)) return std::nullopt;
      continue;
    }
    double t[2] = {(box.low(axis) - origin(axis)) / bearing(axis), (box.high(axis) - origin(axis)) / bearing(axis)};
    const int first = t[0] <= t[1] ? 0 : 1;
    if (t[first] > enter) enter = t[first], enter_face = 2 * axis + first;
    if (t[1 - first] < exit) exit = t[1 - first], exit_face = 2 * axis + 1 - first;
  }
  if (enter >= exit) return std::nullopt;
  if (from_inside) return std::pair{exit, exit_face};
  if (enter_face < 0) return std::nullopt;
  return std::pair{enter, enter_face};
}

/// Whether nothing of the room lies between the camera and a point on its surface.
inline bool truly_visible(const TestRoom& room, const Eigen::Vector3d& center, const Eigen::Vector3d& x) {
  const double range = (x - center).norm();
  for (const Box& box : room.boxes) {
    const Box shrunk{box.low.array() + 1e-4, box.high.array() - 1e-4};
    const auto hit = cast_box(shrunk, center, (x - center) / range, false);
    if (hit && hit->first < range) return false;
  }
  return true;
}

/// The plane seen through the middle of each cell.
inline PlaneBuffer cast_plane_buffer(const TestRoom& room, const Camera& camera, const Rigid3& camera_from_map,
                                     double cell_px = 4.0) {
  PlaneBuffer buffer;
  buffer.camera = camera;
  buffer.camera_from_map = camera_from_map;
  buffer.cell_px = cell_px;
  buffer.planes = &room.planes;
  buffer.plane = Image<int32_t>(static_cast<int>(std::ceil(camera.width() / cell_px)),
                                static_cast<int>(std::ceil(camera.height() / cell_px)), PlaneBuffer::kNone);
  const Eigen::Vector3d center = camera_center(camera_from_map);
  for (int y = 0; y < buffer.plane.height; ++y) {
    for (int x = 0; x < buffer.plane.width; ++x) {
      const auto bearing = camera.unproject({(x + 0.5) * cell_px - 0.5, (y + 0.5) * cell_px - 0.5});
      if (!bearing) continue;
      const Eigen::Vector3d bearing_in_map = camera_from_map.rotation.conjugate() * *bearing;
      double nearest = std::numeric_limits<double>::max();
      int32_t plane = PlaneBuffer::kNone;
      int32_t first_plane = 0;
      const auto try_box = [&](const Box& box, bool from_inside) {
        const auto hit = cast_box(box, center, bearing_in_map, from_inside);
        if (hit && hit->first < nearest) nearest = hit->first, plane = first_plane + hit->second;
        first_plane += 6;
      };
      if (room.shell) try_box(*room.shell, true);
      for (const Box& box : room.boxes) try_box(box, false);
      buffer.plane.at(x, y) = plane;
    }
  }
  return buffer;
}

/// Samples of the room's edges that a camera should see.
inline std::vector<EdgeSample> samples_in_view(const TestRoom& room, const Camera& camera,
                                               const Rigid3& camera_from_map) {
  return sample_visible_edges(room.edges, camera, camera_from_map, cast_plane_buffer(room, camera, camera_from_map),
                              {});
}

/// camera_from_map of a camera that looks from one point to another, upright.
inline Rigid3 look_at(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d z = (to - from).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d camera_from_map;
  camera_from_map << x.transpose(), z.cross(x).transpose(), z.transpose();
  return Rigid3(camera_from_map, -camera_from_map * from);
}

inline Camera test_camera() {
  return Camera(CameraModel::kOpenCv, 640, 480, {330, 334, 321, 238, -0.08, 0.02, 0.0005, -0.0003});
}

inline Rigid3 true_view() { return look_at({0.9, 0.8, 1.6}, {4.4, 3.7, 1.2}); }

struct DrawnNoise {
  double edgel_sigma_px = 0.3;  // across the edge, each edgel its own
  double edge_sigma_px = 0.0;   // across the edge, all edgels of an edge alike
  double direction_sigma_deg = 2.0;
  double textured_share = 0.0;  // of the edges have a parallel line of texture 6 to 12 px beside them
  int clutter_chains = 0;       // straight chains of edgels anywhere
  bool room = true;             // false: clutter alone
  uint64_t seed = 1;
};

/// Collects edgels, one a pixel, in row-major order.
class EdgelDrawing {
 public:
  EdgelDrawing(const Camera& camera, const DrawnNoise& noise) : camera_(camera), noise_(noise), random_(noise.seed) {}

  Random& random() { return random_; }

  void add(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal, double offset_px) {
    const Eigen::Vector2d p = pixel + (offset_px + noise_.edgel_sigma_px * random_.normal()) * normal;
    if (!camera_.in_image(p, 1.0)) return;
    const double turn = noise_.direction_sigma_deg * std::numbers::pi / 180.0 * random_.normal();
    const Eigen::Vector2d n(std::cos(turn) * normal.x() - std::sin(turn) * normal.y(),
                            std::sin(turn) * normal.x() + std::cos(turn) * normal.y());
    ImageEdgel edgel;
    edgel.pixel = p.cast<float>();
    edgel.normal = n.cast<float>();
    edgel.gradient = 20.0f;
    edgels_.try_emplace({std::lround(p.y()), std::lround(p.x())}, edgel);
  }

  void add_chain() {
    const Eigen::Vector2d start(random_.uniform(0, camera_.width()), random_.uniform(0, camera_.height()));
    const double angle = random_.uniform(0, 2 * std::numbers::pi);
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const double length = random_.uniform(15, 60);
    for (double s = 0; s < length; s += 0.8) add(start + s * direction, {-direction.y(), direction.x()}, 0.0);
  }

  ImageEdges edges() const {
    ImageEdges edges;
    edges.width = camera_.width();
    edges.height = camera_.height();
    for (const auto& [position, edgel] : edgels_) edges.edgels.push_back(edgel);
    return edges;
  }

 private:
  const Camera& camera_;
  DrawnNoise noise_;
  Random random_;
  std::map<std::pair<long, long>, ImageEdgel> edgels_;
};

/// Where a point falls when rows are exposed one after the other.
inline std::optional<Eigen::Vector2d> project_by_rows(const Camera& camera, const ImagePose& pose,
                                                      const Eigen::Vector3d& x_in_map) {
  auto pixel = camera.project(pose.camera_from_map * x_in_map);
  for (int k = 0; pixel && pose.moves() && k < 10; ++k) {
    pixel = camera.project(pose.at(row_fraction(pixel->y(), camera.height())) * x_in_map);
  }
  return pixel;
}

/// What an edge detector would find in a photograph of the room.
inline ImageEdges draw_room(const TestRoom& room, const Camera& camera, const ImagePose& pose,
                            const DrawnNoise& noise) {
  EdgelDrawing drawing(camera, noise);
  const Eigen::Vector3d center = camera_center(pose.camera_from_map);
  for (int pass = 0; noise.room && pass < 2; ++pass) {  // texture after all edges, so that it covers none
    for (const MapEdge& edge : room.edges) {
      const double edge_offset = noise.edge_sigma_px * drawing.random().normal();
      const bool textured = drawing.random().uniform() < noise.textured_share;
      const double beside = drawing.random().uniform(6, 12) * (drawing.random().uniform() < 0.5 ? -1 : 1);
      if (pass == 1 && !textured) continue;
      const int count = static_cast<int>(std::ceil(edge.length() * 800));
      Eigen::Vector2d last(-1e9, -1e9);
      for (int k = 0; k < count; ++k) {
        const Eigen::Vector3d x = edge.start + (k + 0.5) / count * (edge.end - edge.start);
        const auto pixel = project_by_rows(camera, pose, x);
        if (!pixel || !camera.in_image(*pixel) || (*pixel - last).norm() < 0.6) continue;
        const auto ahead = project_by_rows(camera, pose, x + 1e-4 * edge.direction());
        if (!ahead || !truly_visible(room, center, x)) continue;
        last = *pixel;
        const Eigen::Vector2d tangent = (*ahead - *pixel).normalized();
        drawing.add(*pixel, {-tangent.y(), tangent.x()}, pass == 0 ? edge_offset : beside);
      }
    }
  }
  for (int i = 0; i < noise.clutter_chains; ++i) drawing.add_chain();
  return drawing.edges();
}

inline Eigen::Vector3d random_direction(Random* random) {
  Eigen::Vector3d v(random->normal(), random->normal(), random->normal());
  return v.normalized();
}

/// A pose that is off by exactly this angle and this distance, in directions that the seed chooses.
inline Rigid3 disturbed(const Rigid3& camera_from_map, double angle_deg, double distance_m, uint64_t seed) {
  Random random(seed);
  Vector6d delta;
  delta.head<3>() = angle_deg * std::numbers::pi / 180.0 * random_direction(&random);
  delta.tail<3>() = distance_m * random_direction(&random);
  return perturb_camera(camera_from_map, delta);
}

/// Mean distance between the projections of the edges' visible points from two poses, pixels.
inline double mean_shift_px(const TestRoom& room, const Camera& camera, const Rigid3& true_camera_from_map,
                            const Rigid3& camera_from_map) {
  double sum = 0.0;
  int count = 0;
  for (const MapEdge& edge : room.edges) {
    for (int k = 0; k < 50; ++k) {
      const Eigen::Vector3d x = edge.start + (k + 0.5) / 50 * (edge.end - edge.start);
      const auto expected = camera.project(true_camera_from_map * x);
      if (!expected || !camera.in_image(*expected)) continue;
      if (!truly_visible(room, camera_center(true_camera_from_map), x)) continue;
      const auto pixel = camera.project(camera_from_map * x);
      if (!pixel) return std::numeric_limits<double>::infinity();
      sum += (*pixel - *expected).norm();
      ++count;
    }
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

}  // namespace cpplus
