#include "cpplus/simulate/lighting.h"

#include <algorithm>
#include <cmath>

#include "cpplus/core/random.h"
#include "cpplus/simulate/hash.h"

namespace cpplus {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr int kHemisphereStrata = 6;  // squared = rays a cell
constexpr int kLightStrata = 3;       // squared = points a lamp
constexpr int kMaxCellsPerSide = 1024;
constexpr float kSurfaceOffset = 2e-3f;
constexpr float kMaxValue = 32.0f;

uint64_t pack(const Vector3f& color) {
  uint64_t word = 1;
  for (int k = 0; k < 3; ++k) {
    const float clamped = std::clamp(color[k] / kMaxValue, 0.0f, 1.0f);
    word = (word << 21) | static_cast<uint64_t>(clamped * 2097151.0f);
  }
  return word;
}

Vector3f unpack(uint64_t word) {
  constexpr uint64_t kMask = 2097151;
  const auto part = [&](int shift) { return static_cast<float>((word >> shift) & kMask) * (kMaxValue / 2097151.0f); };
  return {part(42), part(21), part(0)};
}

/// Moves uv to the nearest place inside the polygon, a little off its border.
Vector3f clamp_into_face(const MeshFace& face, const Vector3f& point) {
  Vector3f inside = point;
  for (int round = 0; round < 4; ++round) {
    for (size_t i = 0; i < face.corners.size(); ++i) {
      const Vector3f& a = face.corners[i];
      const Vector3f edge = face.corners[(i + 1) % face.corners.size()] - a;
      if (edge.squaredNorm() < 1e-12f) continue;
      const Vector3f inward = face.normal.cross(edge).normalized();
      const float depth = inward.dot(inside - a);
      if (depth < 1e-3f) inside += (1e-3f - depth) * inward;
    }
  }
  return inside;
}

}  // namespace

Vector3f sky_radiance(const Sky& sky, const Vector3f& direction) {
  const float up = std::clamp(direction.z(), 0.0f, 1.0f);
  Vector3f color = sky.horizon + std::sqrt(up) * (sky.zenith - sky.horizon);
  if (direction.z() > 0.02f) {
    const Vector2f x = direction.head<2>() / (direction.z() + 0.15f);
    const float cloud = std::clamp(2.5f * fractal_noise(x * 1.3f, 5, 0.0f, sky.seed) - 0.1f, 0.0f, 1.0f);
    color += cloud * std::min(1.0f, 4.0f * up) * (1.15f * Vector3f::Constant(sky.horizon.maxCoeff()) - color);
  }
  return color;
}

LightCells::LightCells(const Mesh& mesh, float cell_m) {
  size_t num_cells = 0;
  for (const MeshFace& face : mesh.faces) {
    Vector2f low = face.uv(face.corners[0]);
    Vector2f high = low;
    for (const Vector3f& corner : face.corners) {
      low = low.cwiseMin(face.uv(corner));
      high = high.cwiseMax(face.uv(corner));
    }
    FaceGrid grid;
    const auto cells = [&](float extent) {
      return face.has_edges ? std::clamp(static_cast<int>(std::ceil(extent / cell_m)) + 1, 2, kMaxCellsPerSide) : 1;
    };
    grid.first = num_cells;
    grid.columns = cells(high.x() - low.x());
    grid.rows = cells(high.y() - low.y());
    grid.low = low;
    grid.step = (high - low)
                    .cwiseQuotient(Vector2f(static_cast<float>(std::max(1, grid.columns - 1)),
                                            static_cast<float>(std::max(1, grid.rows - 1))));
    grid.step = grid.step.cwiseMax(1e-6f);
    num_cells += static_cast<size_t>(grid.columns) * static_cast<size_t>(grid.rows);
    grids_.push_back(grid);
  }
  cells_ = std::make_unique<std::atomic<std::atomic<uint64_t>*>[]>(grids_.size());
}

LightCells::~LightCells() {
  for (size_t i = 0; i < grids_.size(); ++i) delete[] cells_[i].load();
}

std::atomic<uint64_t>* LightCells::cells(uint32_t face_index) const {
  std::atomic<uint64_t>* known = cells_[face_index].load();
  if (known != nullptr) return known;
  const FaceGrid& grid = grids_[face_index];
  auto fresh =
      std::make_unique<std::atomic<uint64_t>[]>(static_cast<size_t>(grid.columns) * static_cast<size_t>(grid.rows));
  // Of two threads that come at once, one finds the other's.
  return cells_[face_index].compare_exchange_strong(known, fresh.get()) ? fresh.release() : known;
}

SoftLight::SoftLight(const Tracer& tracer, float cell_m) : tracer_(tracer) {
  for (const auto& part : tracer.parts()) parts_.push_back(std::make_shared<const LightCells>(part->mesh(), cell_m));
}

Vector3f SoftLight::at(const TraceHit& hit) const {
  if (hit.body >= 0) {
    return gather(hit.point, hit.normal, hash_seed(static_cast<uint64_t>(hit.body), hit.face_index));
  }
  const LightCells::FaceGrid& grid = parts_[hit.part]->grid(hit.face_index);
  if (grid.columns == 1 && grid.rows == 1) return cell_value(hit, 0, 0);
  const Vector2f x = (hit.face->uv(hit.point) - grid.low).cwiseQuotient(grid.step);
  const int column = std::clamp(static_cast<int>(x.x()), 0, std::max(0, grid.columns - 2));
  const int row = std::clamp(static_cast<int>(x.y()), 0, std::max(0, grid.rows - 2));
  const float s = std::clamp(x.x() - static_cast<float>(column), 0.0f, 1.0f);
  const float t = std::clamp(x.y() - static_cast<float>(row), 0.0f, 1.0f);
  return (1 - s) * (1 - t) * cell_value(hit, column, row) + s * (1 - t) * cell_value(hit, column + 1, row) +
         (1 - s) * t * cell_value(hit, column, row + 1) + s * t * cell_value(hit, column + 1, row + 1);
}

Vector3f SoftLight::cell_value(const TraceHit& hit, int column, int row) const {
  const LightCells& cells = *parts_[hit.part];
  const LightCells::FaceGrid& grid = cells.grid(hit.face_index);
  const size_t place = static_cast<size_t>(row) * static_cast<size_t>(grid.columns) + static_cast<size_t>(column);
  std::atomic<uint64_t>& cell = cells.cells(hit.face_index)[place];
  const uint64_t known = cell.load(std::memory_order_relaxed);
  if (known != 0) return unpack(known);
  const MeshFace& face = *hit.face;
  Vector2f uv = grid.low + grid.step.cwiseProduct(Vector2f(static_cast<float>(column), static_cast<float>(row)));
  if (grid.columns == 1) uv = face.uv((face.corners[0] + face.corners[1] + face.corners[2]) / 3.0f);
  const Vector3f on_plane = face.uv_origin + uv.x() * face.u_axis + uv.y() * face.v_axis;
  // uv_origin need not lie in the plane of the face; the normal part comes from a corner.
  const Vector3f point = on_plane + face.normal * face.normal.dot(face.corners[0] - on_plane);
  const uint64_t word = pack(gather(clamp_into_face(face, point), face.normal, hash_seed(977, grid.first + place)));
  cell.store(word, std::memory_order_relaxed);
  return unpack(word);
}

Vector3f SoftLight::gather(const Vector3f& point, const Vector3f& normal, uint64_t seed) const {
  const Scene& scene = tracer_.scene();
  Random random(seed);
  const Vector3f origin = point + kSurfaceOffset * normal;
  Vector3f sum = Vector3f::Zero();
  // Lamps, sampled in strata.
  for (const AreaLight& light : scene.lights) {
    const Vector3f light_normal = light.half_u.cross(light.half_v).normalized();
    const float area = 4.0f * light.half_u.cross(light.half_v).norm();
    if (normal.dot(light.center - point) < -light.half_u.norm() - light.half_v.norm()) continue;
    Vector3f from_light = Vector3f::Zero();
    for (int i = 0; i < kLightStrata * kLightStrata; ++i) {
      const float a =
          2.0f * (static_cast<float>(i % kLightStrata) + static_cast<float>(random.uniform())) / kLightStrata - 1.0f;
      const float b =
          2.0f * (static_cast<float>(i / kLightStrata) + static_cast<float>(random.uniform())) / kLightStrata - 1.0f;
      const Vector3f to_light = light.center + a * light.half_u + b * light.half_v - origin;
      const float distance = to_light.norm();
      const Vector3f direction = to_light / distance;
      const float cosines = normal.dot(direction) * std::max(0.0f, -light_normal.dot(direction));
      if (normal.dot(direction) <= 0.0f || cosines <= 0.0f) continue;
      if (tracer_.occluded_static(origin, direction, distance - 2.0f * kSurfaceOffset)) continue;
      from_light +=
          light.radiance * (cosines * area / (static_cast<float>(M_PI) * std::max(0.05f, distance * distance)));
    }
    sum += from_light / static_cast<float>(kLightStrata * kLightStrata);
  }
  // Sky and ambient light over the cosine-weighted hemisphere.
  const Vector3f helper = std::abs(normal.z()) < 0.9f ? Vector3f::UnitZ() : Vector3f::UnitX();
  const Vector3f tangent = helper.cross(normal).normalized();
  const Vector3f bitangent = normal.cross(tangent);
  Vector3f diffuse = Vector3f::Zero();
  for (int i = 0; i < kHemisphereStrata * kHemisphereStrata; ++i) {
    const float a =
        (static_cast<float>(i % kHemisphereStrata) + static_cast<float>(random.uniform())) / kHemisphereStrata;
    const float b =
        (static_cast<float>(i / kHemisphereStrata) + static_cast<float>(random.uniform())) / kHemisphereStrata;
    const float radius = std::sqrt(a);
    const float angle = 2.0f * static_cast<float>(M_PI) * b;
    const Vector3f direction = radius * std::cos(angle) * tangent + radius * std::sin(angle) * bitangent +
                               std::sqrt(std::max(0.0f, 1.0f - a)) * normal;
    const auto hit = tracer_.trace_static(origin, direction);
    if (!hit) {
      diffuse += sky_radiance(scene.sky, direction);
      continue;
    }
    const Material& material = *hit->material;
    const float open = 1.0f - std::exp(-hit->range / scene.sky.ambient_reach_m);
    const Vector3f tint = 0.4f * Vector3f::Ones() + 0.9f * albedo(material, hit->uv, 0.5f);
    diffuse += open * scene.sky.ambient.cwiseProduct(tint);
  }
  return sum + diffuse / static_cast<float>(kHemisphereStrata * kHemisphereStrata);
}

}  // namespace cpplus
