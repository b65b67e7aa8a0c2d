#include "cpplus/visibility/hidden_point_removal.h"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include <algorithm>
#include <cstdio>
#include <memory>
#include <numeric>

#include "cpplus/core/error.h"
#include "cpplus/core/options.h"

namespace cpplus {
namespace {

/// Vertices of the convex hull of xyz triples; empty where Qhull finds none.
std::vector<uint32_t> convex_hull_vertices(std::vector<double>* coordinates) {
  const std::unique_ptr<FILE, int (*)(FILE*)> messages(std::fopen("/dev/null", "w"), &std::fclose);
  qhT state;
  qh_zero(&state, messages.get());
  std::vector<uint32_t> vertices;
  char command[] = "qhull";
  const int num_points = static_cast<int>(coordinates->size() / 3);
  if (qh_new_qhull(&state, 3, num_points, coordinates->data(), False, command, nullptr, messages.get()) == 0) {
    for (const vertexT* vertex = state.vertex_list; vertex && vertex->next; vertex = vertex->next)
      vertices.push_back(static_cast<uint32_t>(qh_pointid(&state, vertex->point)));
  }
  qh_freeqhull(&state, !qh_ALL);
  int num_long_blocks = 0;
  int bytes_of_long_blocks = 0;
  qh_memfreeshort(&state, &num_long_blocks, &bytes_of_long_blocks);
  return vertices;
}

}  // namespace

std::vector<uint32_t> remove_hidden_points(const std::vector<Eigen::Vector3d>& points, double radius_factor) {
  check_option(radius_factor >= 0.5, "radius_factor", "[0.5, inf)", radius_factor);
  double max_distance = 0.0;
  for (const Eigen::Vector3d& x : points) {
    if (!x.allFinite()) throw Error("hidden point removal: a point is not finite");
    max_distance = std::max(max_distance, x.norm());
  }
  const double diameter = 2.0 * radius_factor * max_distance;

  // In units of the sphere's diameter, so that Qhull's tolerances do not depend on the scene's size.
  std::vector<double> flipped;
  std::vector<uint32_t> sources;
  flipped.reserve(3 * (points.size() + 1));
  for (uint32_t i = 0; i < points.size(); ++i) {
    const double distance = points[i].norm();
    if (distance == 0.0) continue;
    const Eigen::Vector3d f = points[i] * ((diameter - distance) / (distance * diameter));  // Eq. 3
    flipped.insert(flipped.end(), f.data(), f.data() + 3);
    sources.push_back(i);
  }
  flipped.insert(flipped.end(), 3, 0.0);  // the viewpoint
  std::vector<uint32_t> visible;
  const std::vector<uint32_t> vertices = sources.size() < 4 ? std::vector<uint32_t>() : convex_hull_vertices(&flipped);
  if (vertices.empty()) return sources;
  for (const uint32_t vertex : vertices) {
    if (vertex < sources.size()) visible.push_back(sources[vertex]);
  }
  std::sort(visible.begin(), visible.end());
  return visible;
}

}  // namespace cpplus
