#include "cpplus/simulate/tracer.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace cpplus {
namespace {

using Eigen::Vector3f;

RTCRay make_ray(const Vector3f& origin, const Vector3f& direction, float max_range) {
  RTCRay ray;
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tnear = 0.0f;
  ray.tfar = max_range;
  ray.time = 0.0f;
  ray.mask = 0xffffffffu;  // Debian builds Embree with ray masks: any other value misses everything
  ray.id = 0;
  ray.flags = 0;
  return ray;
}

struct RawHit {
  float range = 0.0f;
  uint32_t part = 0;
  uint32_t triangle = 0;
};

/// Many scenes as one: the parts keep what they have built, and only their boxes are sorted.
RTCScene put_together(const Tracer::Parts& parts) {
  RTCScene scene = rtcNewScene(embree_device());
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  for (size_t i = 0; i < parts.size(); ++i) {
    RTCGeometry instance = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, parts[i]->embree_scene());
    rtcCommitGeometry(instance);
    rtcAttachGeometryByID(scene, instance, static_cast<unsigned>(i));
    rtcReleaseGeometry(instance);
  }
  rtcCommitScene(scene);
  return scene;
}

std::optional<RawHit> intersect(RTCScene scene, const Vector3f& origin, const Vector3f& direction, float max_range) {
  RTCRayHit query;
  query.ray = make_ray(origin, direction, max_range);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const uint32_t instance = query.hit.instID[0];
  return RawHit{query.ray.tfar, instance == RTC_INVALID_GEOMETRY_ID ? 0 : instance, query.hit.primID};
}

bool is_occluded(RTCScene scene, const Vector3f& origin, const Vector3f& direction, float max_range) {
  RTCRay ray = make_ray(origin, direction, max_range);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
  return ray.tfar < 0.0f;
}

bool ray_meets_sphere(const Vector3f& origin, const Vector3f& direction, const Vector3f& center, float radius) {
  const Vector3f to_center = center - origin;
  const float along = to_center.dot(direction);
  if (along < -radius) return false;
  return (to_center - along * direction).squaredNorm() < radius * radius;
}

}  // namespace

BodyPoses body_poses(const Scene& scene, double time_s) {
  BodyPoses result;
  for (const MovingBody& body : scene.bodies) {
    const Rigid3 map_from_body = body.map_from_body(time_s);
    result.poses.push_back(
        {map_from_body.rotation.conjugate().toRotationMatrix().cast<float>(), map_from_body.translation.cast<float>()});
  }
  return result;
}

struct Tracer::Impl {
  struct Body {
    std::unique_ptr<TracedMesh> mesh;
    Vector3f center = Vector3f::Zero();  // of a ball that holds the body, body frame
    float radius = 0.0f;
  };

  explicit Impl(const Scene& scene) : world(scene) {}
  ~Impl() {
    if (static_scene != nullptr) rtcReleaseScene(static_scene);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const Scene& world;
  Parts parts;
  RTCScene static_scene = nullptr;
  std::vector<Body> bodies;
};

Tracer::Tracer(const Scene& scene)
    : Tracer(scene, Parts{std::make_shared<const TracedMesh>(scene.mesh, scene.materials)}) {}

Tracer::Tracer(const Scene& scene, Parts parts) : impl_(std::make_unique<Impl>(scene)) {
  set_parts(std::move(parts));
  for (const MovingBody& body : scene.bodies) {
    Impl::Body entry;
    entry.mesh = std::make_unique<TracedMesh>(body.mesh, scene.materials);
    Vector3f low = Vector3f::Constant(std::numeric_limits<float>::max());
    Vector3f high = -low;
    for (const Vector3f& vertex : body.mesh.vertices) {
      low = low.cwiseMin(vertex);
      high = high.cwiseMax(vertex);
    }
    entry.center = 0.5f * (low + high);
    entry.radius = 0.5f * (high - low).norm() + 1e-3f;
    impl_->bodies.push_back(std::move(entry));
  }
}

Tracer::~Tracer() = default;

const Scene& Tracer::scene() const { return impl_->world; }

const Tracer::Parts& Tracer::parts() const { return impl_->parts; }

void Tracer::set_parts(Parts parts) {
  if (impl_->static_scene != nullptr) rtcReleaseScene(impl_->static_scene);
  impl_->parts = std::move(parts);
  if (impl_->parts.size() == 1) {
    impl_->static_scene = impl_->parts.front()->embree_scene();  // spares every ray a level
    rtcRetainScene(impl_->static_scene);
  } else {
    impl_->static_scene = put_together(impl_->parts);
  }
}

std::optional<TraceHit> Tracer::trace_static(const Vector3f& origin, const Vector3f& direction,
                                             float max_range_m) const {
  const auto raw = intersect(impl_->static_scene, origin, direction, max_range_m);
  if (!raw) return std::nullopt;
  const TracedMesh& part = *impl_->parts[raw->part];
  TraceHit hit;
  hit.range = raw->range;
  hit.point = origin + raw->range * direction;
  hit.part = raw->part;
  hit.face_index = part.mesh().triangle_faces[raw->triangle];
  hit.face = &part.mesh().faces[hit.face_index];
  hit.material = &part.materials()[hit.face->material];
  hit.normal = hit.face->normal;
  hit.uv = hit.face->uv(hit.point);
  return hit;
}

std::optional<TraceHit> Tracer::trace(const Vector3f& origin, const Vector3f& direction,
                                      const BodyPoses& bodies) const {
  std::optional<TraceHit> best = trace_static(origin, direction);
  for (size_t i = 0; i < impl_->bodies.size(); ++i) {
    const Impl::Body& body = impl_->bodies[i];
    const BodyPoses::Pose& pose = bodies.poses[i];
    const Vector3f local_origin = pose.body_from_map_rotation * (origin - pose.body_in_map);
    const Vector3f local_direction = pose.body_from_map_rotation * direction;
    if (!ray_meets_sphere(local_origin, local_direction, body.center, body.radius)) continue;
    const auto raw = intersect(body.mesh->embree_scene(), local_origin, local_direction, best ? best->range : 1e4f);
    if (!raw) continue;
    const Mesh& mesh = body.mesh->mesh();
    TraceHit hit;
    hit.range = raw->range;
    hit.point = origin + raw->range * direction;
    hit.face_index = mesh.triangle_faces[raw->triangle];
    hit.face = &mesh.faces[hit.face_index];
    hit.material = &body.mesh->materials()[hit.face->material];
    hit.normal = pose.body_from_map_rotation.transpose() * hit.face->normal;
    hit.uv = hit.face->uv(local_origin + raw->range * local_direction);
    hit.body = static_cast<int>(i);
    best = hit;
  }
  return best;
}

bool Tracer::occluded_static(const Vector3f& origin, const Vector3f& direction, float max_range_m) const {
  return is_occluded(impl_->static_scene, origin, direction, max_range_m);
}

bool Tracer::occluded(const Vector3f& origin, const Vector3f& direction, float max_range_m,
                      const BodyPoses& bodies) const {
  if (is_occluded(impl_->static_scene, origin, direction, max_range_m)) return true;
  for (size_t i = 0; i < impl_->bodies.size(); ++i) {
    const BodyPoses::Pose& pose = bodies.poses[i];
    const Vector3f local_origin = pose.body_from_map_rotation * (origin - pose.body_in_map);
    const Vector3f local_direction = pose.body_from_map_rotation * direction;
    const Impl::Body& body = impl_->bodies[i];
    if (!ray_meets_sphere(local_origin, local_direction, body.center, body.radius)) continue;
    if (is_occluded(body.mesh->embree_scene(), local_origin, local_direction, max_range_m)) return true;
  }
  return false;
}

}  // namespace cpplus
