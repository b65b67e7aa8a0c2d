#pragma once

#include <vector>

#include "cpplus/simulate/material.h"
#include "cpplus/simulate/mesh.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace cpplus {

/// A mesh and what it is made of, ready for rays (Embree): built once, it can be part of any number of scenes.
class TracedMesh {
 public:
  /// Mesh and materials must outlive it.
  TracedMesh(const Mesh& mesh, const std::vector<Material>& materials);
  ~TracedMesh();
  TracedMesh(const TracedMesh&) = delete;
  TracedMesh& operator=(const TracedMesh&) = delete;

  const Mesh& mesh() const { return mesh_; }
  const std::vector<Material>& materials() const { return materials_; }
  RTCSceneTy* embree_scene() const { return scene_; }

 private:
  const Mesh& mesh_;
  const std::vector<Material>& materials_;
  RTCSceneTy* scene_ = nullptr;
};

/// The one device of the program: only what is of the same device can be put together. Throws Error where there is
/// none.
RTCDeviceTy* embree_device();

}  // namespace cpplus
