#include "cpplus/simulate/traced_mesh.h"

#include <embree3/rtcore.h>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

struct Device {
  // Without "threads": that would set a limit for all of TBB, the program's own loops included.
  RTCDevice device = rtcNewDevice("set_affinity=0");
  ~Device() { rtcReleaseDevice(device); }
};

RTCScene build_embree_scene(RTCDevice device, const Mesh& mesh) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), mesh.vertices.size()));
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                 3 * sizeof(unsigned), mesh.triangles.size()));
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (int k = 0; k < 3; ++k) vertices[3 * i + static_cast<size_t>(k)] = mesh.vertices[i][k];
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) indices[3 * i + static_cast<size_t>(k)] = static_cast<unsigned>(mesh.triangles[i][k]);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  const SingleThread same_tree_each_time;
  rtcCommitScene(scene);
  return scene;
}

}  // namespace

RTCDeviceTy* embree_device() {
  static const Device shared;
  if (shared.device == nullptr) throw Error("Embree gives no device");
  return shared.device;
}

TracedMesh::TracedMesh(const Mesh& mesh, const std::vector<Material>& materials)
    : mesh_(mesh), materials_(materials), scene_(build_embree_scene(embree_device(), mesh)) {}

TracedMesh::~TracedMesh() { rtcReleaseScene(scene_); }

}  // namespace cpplus
