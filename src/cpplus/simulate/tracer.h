#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "cpplus/simulate/scene.h"
#include "cpplus/simulate/traced_mesh.h"

namespace cpplus {

struct TraceHit {
  float range = 0.0f;                                // metres
  Eigen::Vector3f point = Eigen::Vector3f::Zero();   // map frame
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // outward, map frame
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();      // on the face, metres
  const MeshFace* face = nullptr;
  const Material* material = nullptr;
  int body = -1;            // index in Scene::bodies; -1 = static
  uint32_t part = 0;        // of the static scene
  uint32_t face_index = 0;  // in its mesh
};

/// Where the moving bodies are at one instant; taken once for many rays.
struct BodyPoses {
  struct Pose {
    Eigen::Matrix3f body_from_map_rotation = Eigen::Matrix3f::Identity();
    Eigen::Vector3f body_in_map = Eigen::Vector3f::Zero();
  };
  std::vector<Pose> poses;  // in the order of Scene::bodies
};

BodyPoses body_poses(const Scene& scene, double time_s);

/// Casts rays into a scene (Embree). The scene must outlive the tracer. All queries are const and thread-safe.
class Tracer {
 public:
  using Parts = std::vector<std::shared_ptr<const TracedMesh>>;

  explicit Tracer(const Scene& scene);
  /// The static scene is what the parts make up together, in place of the scene's own mesh.
  Tracer(const Scene& scene, Parts parts);
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  const Scene& scene() const;
  const Parts& parts() const;
  /// Takes other parts. No query may be running.
  void set_parts(Parts parts);

  /// First surface along a ray (unit direction, map frame) of the static scene.
  std::optional<TraceHit> trace_static(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                                       float max_range_m = 1e4f) const;
  /// The same with the moving bodies.
  std::optional<TraceHit> trace(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                                const BodyPoses& bodies) const;
  /// Whether something static lies between.
  bool occluded_static(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float max_range_m) const;
  /// Whether anything, moving bodies included, lies between.
  bool occluded(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float max_range_m,
                const BodyPoses& bodies) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cpplus
