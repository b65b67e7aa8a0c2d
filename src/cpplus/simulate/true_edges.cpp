#include "cpplus/simulate/true_edges.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kTouch = 5e-4;  // faces nearer than this touch
constexpr double kSide = 3e-3;   // a face lies on a side of a line if it reaches this far
constexpr double kProbe = 6e-3;  // how far from the edge its surroundings are looked at
constexpr double kSampleStep = 0.01;
constexpr double kJoinGap = 0.025;

/// A face in double precision.
struct FlatFace {
  std::vector<Vector3d> corners;
  Vector3d normal;
  Vector3d low;
  Vector3d high;
  uint32_t object;
};

/// Part of a line p + t d, from t = begin to t = end.
struct Line {
  Vector3d point;
  Vector3d direction;
  double begin = -std::numeric_limits<double>::max();
  double end = std::numeric_limits<double>::max();
};

struct Candidate {
  Line line;
  Vector3d normal_a, normal_b;
  Vector3d into_a, into_b;  // unit, in the faces, away from the edge
  bool convex;
  uint32_t object_a, object_b;
};

std::vector<FlatFace> flat_faces(const Mesh& mesh) {
  std::vector<FlatFace> faces;
  for (const MeshFace& face : mesh.faces) {
    if (!face.has_edges) continue;
    FlatFace flat;
    flat.low = Vector3d::Constant(std::numeric_limits<double>::max());
    flat.high = -flat.low;
    for (const Vector3f& corner : face.corners) {
      flat.corners.push_back(corner.cast<double>());
      flat.low = flat.low.cwiseMin(flat.corners.back());
      flat.high = flat.high.cwiseMax(flat.corners.back());
    }
    flat.normal = face.normal.cast<double>().normalized();
    flat.object = face.object;
    faces.push_back(std::move(flat));
  }
  std::sort(faces.begin(), faces.end(), [](const FlatFace& a, const FlatFace& b) { return a.low.x() < b.low.x(); });
  return faces;
}

/// Shortens the line to the part over a convex polygon (grown by kTouch).
void clip(const FlatFace& face, Line* line) {
  for (size_t i = 0; i < face.corners.size(); ++i) {
    const Vector3d edge = face.corners[(i + 1) % face.corners.size()] - face.corners[i];
    if (edge.squaredNorm() < 1e-12) continue;
    const Vector3d inward = face.normal.cross(edge).normalized();
    const double offset = inward.dot(line->point - face.corners[i]) + kTouch;
    const double slope = inward.dot(line->direction);
    if (std::abs(slope) < 1e-9) {
      if (offset < 0.0) line->end = -std::numeric_limits<double>::max();
    } else if (slope > 0.0) {
      line->begin = std::max(line->begin, -offset / slope);
    } else {
      line->end = std::min(line->end, -offset / slope);
    }
  }
}

/// How far a face reaches to both sides of a line in its plane, along `across`.
std::array<double, 2> reach(const FlatFace& face, const Line& line, const Vector3d& across) {
  std::array<double, 2> result = {0.0, 0.0};
  for (const Vector3d& corner : face.corners) {
    const double side = across.dot(corner - line.point);
    result[0] = std::min(result[0], side);
    result[1] = std::max(result[1], side);
  }
  return result;
}

void add_candidates(const FlatFace& a, const FlatFace& b, const TrueEdgeOptions& options,
                    std::vector<Candidate>* candidates) {
  const Vector3d cross = a.normal.cross(b.normal);
  if (cross.norm() < std::sin(options.min_angle_deg * M_PI / 180.0)) return;
  Line line;
  line.direction = cross.normalized();
  Eigen::Matrix3d planes;
  planes << a.normal.transpose(), b.normal.transpose(), line.direction.transpose();
  const Vector3d middle = 0.5 * (a.low.cwiseMax(b.low) + a.high.cwiseMin(b.high));
  line.point =
      planes.inverse() * Vector3d(a.normal.dot(a.corners[0]), b.normal.dot(b.corners[0]), line.direction.dot(middle));
  clip(a, &line);
  clip(b, &line);
  if (line.end - line.begin < 2.0 * kSampleStep) return;
  const Vector3d across_a = a.normal.cross(line.direction);
  const Vector3d across_b = b.normal.cross(line.direction);
  const auto reach_a = reach(a, line, across_a);
  const auto reach_b = reach(b, line, across_b);
  for (const int side_a : {0, 1}) {
    for (const int side_b : {0, 1}) {
      if (std::abs(reach_a[static_cast<size_t>(side_a)]) < kSide) continue;
      if (std::abs(reach_b[static_cast<size_t>(side_b)]) < kSide) continue;
      Candidate candidate{
          line,  a.normal, b.normal, side_a ? across_a : Vector3d(-across_a), side_b ? across_b : Vector3d(-across_b),
          false, a.object, b.object};
      const double over_a = a.normal.dot(candidate.into_b);
      const double over_b = b.normal.dot(candidate.into_a);
      if (over_a * over_b <= 0.0) continue;  // one is the back of the other
      candidate.convex = over_a < 0.0;
      candidates->push_back(candidate);
    }
  }
}

/// Whether the surface at `target` with `normal` is what a ray from `eye` meets first.
bool sees(const Tracer& tracer, const Vector3d& eye, const Vector3d& target, const Vector3d& normal) {
  const Vector3d ray = target - eye;
  const auto hit = tracer.trace_static(eye.cast<float>(), ray.normalized().cast<float>());
  return hit && std::abs(hit->range - ray.norm()) < 1e-3 && hit->normal.dot(normal.cast<float>()) > 0.99f;
}

bool exposed(const Tracer& tracer, const Candidate& c, double t, double min_opening_m) {
  const Vector3d on_edge = c.line.point + t * c.line.direction;
  const Vector3d outward =
      c.convex ? Vector3d((c.normal_a + c.normal_b).normalized()) : Vector3d((c.into_a + c.into_b).normalized());
  const Vector3d eye = on_edge + 1.5 * kProbe * outward;
  if (!sees(tracer, eye, on_edge + kProbe * c.into_a, c.normal_a)) return false;
  if (!sees(tracer, eye, on_edge + kProbe * c.into_b, c.normal_b)) return false;
  const auto ahead = tracer.trace_static(eye.cast<float>(), outward.cast<float>());
  if (!ahead) return true;
  const bool inside_something = ahead->normal.dot(outward.cast<float>()) > 0.0f;
  return !inside_something && ahead->range > min_opening_m;
}

TrueEdge edge_of(const Candidate& c, double begin, double end) {
  return {c.line.point + begin * c.line.direction,
          c.line.point + end * c.line.direction,
          c.normal_a,
          c.normal_b,
          c.convex,
          c.object_a,
          c.object_b};
}

/// The stretches of a candidate that are exposed.
std::vector<TrueEdge> exposed_stretches(const Tracer& tracer, const Candidate& c, double min_opening_m) {
  std::vector<TrueEdge> edges;
  const int samples = std::max(2, static_cast<int>((c.line.end - c.line.begin) / kSampleStep));
  const double step = (c.line.end - c.line.begin) / samples;
  int run_begin = -1;
  for (int i = 0; i <= samples; ++i) {
    const bool is_exposed = i < samples && exposed(tracer, c, c.line.begin + (i + 0.5) * step, min_opening_m);
    if (is_exposed && run_begin < 0) run_begin = i;
    if (!is_exposed && run_begin >= 0) {
      edges.push_back(edge_of(c, c.line.begin + run_begin * step, c.line.begin + i * step));
      run_begin = -1;
    }
  }
  return edges;
}

bool same_line(const TrueEdge& x, const TrueEdge& y) {
  constexpr double kOffset = 2e-3;
  const Vector3d direction = (x.end - x.begin).normalized();
  const Vector3d to_begin = y.begin - x.begin;
  const Vector3d to_end = y.end - x.begin;
  if ((to_begin - direction * direction.dot(to_begin)).norm() > kOffset) return false;
  if ((to_end - direction * direction.dot(to_end)).norm() > kOffset) return false;
  const bool straight = x.normal_a.dot(y.normal_a) > 0.999 && x.normal_b.dot(y.normal_b) > 0.999;
  const bool swapped = x.normal_a.dot(y.normal_b) > 0.999 && x.normal_b.dot(y.normal_a) > 0.999;
  return x.convex == y.convex && (straight || swapped);
}

/// Joins pieces that overlap or nearly touch on the same line. `edges` must be sorted by their lowest x.
std::vector<TrueEdge> joined(std::vector<TrueEdge> edges) {
  const auto low_x = [](const TrueEdge& e) { return std::min(e.begin.x(), e.end.x()); };
  const auto high_x = [](const TrueEdge& e) { return std::max(e.begin.x(), e.end.x()); };
  std::sort(edges.begin(), edges.end(), [&](const TrueEdge& a, const TrueEdge& b) { return low_x(a) < low_x(b); });
  std::vector<bool> gone(edges.size(), false);
  for (bool changed = true; changed;) {
    changed = false;
    for (size_t i = 0; i < edges.size(); ++i) {
      if (gone[i]) continue;
      for (size_t j = i + 1; j < edges.size() && low_x(edges[j]) < high_x(edges[i]) + kJoinGap; ++j) {
        if (gone[j] || !same_line(edges[i], edges[j])) continue;
        const Vector3d direction = (edges[i].end - edges[i].begin).normalized();
        const double length = (edges[i].end - edges[i].begin).norm();
        double low = direction.dot(edges[j].begin - edges[i].begin);
        double high = direction.dot(edges[j].end - edges[i].begin);
        if (low > high) std::swap(low, high);
        if (low > length + kJoinGap || high < -kJoinGap) continue;
        const Vector3d origin = edges[i].begin;
        edges[i].begin = origin + std::min(0.0, low) * direction;
        edges[i].end = origin + std::max(length, high) * direction;
        gone[j] = true;
        changed = true;
      }
    }
  }
  std::vector<TrueEdge> result;
  for (size_t i = 0; i < edges.size(); ++i) {
    if (!gone[i]) result.push_back(edges[i]);
  }
  return result;
}

}  // namespace

std::vector<TrueEdge> find_true_edges(const Tracer& tracer, const TrueEdgeOptions& options) {
  const std::vector<FlatFace> faces = flat_faces(tracer.scene().mesh);
  std::vector<std::vector<TrueEdge>> found(faces.size());
  parallel_for_each(faces.size(), [&](size_t i) {
    std::vector<Candidate> candidates;
    for (size_t j = i + 1; j < faces.size() && faces[j].low.x() <= faces[i].high.x() + kTouch; ++j) {
      if ((faces[j].low.array() > faces[i].high.array() + kTouch).any()) continue;
      if ((faces[i].low.array() > faces[j].high.array() + kTouch).any()) continue;
      add_candidates(faces[i], faces[j], options, &candidates);
    }
    for (const Candidate& candidate : candidates) {
      const auto stretches = exposed_stretches(tracer, candidate, options.min_opening_m);
      found[i].insert(found[i].end(), stretches.begin(), stretches.end());
    }
  });
  std::vector<TrueEdge> edges;
  for (const auto& part : found) edges.insert(edges.end(), part.begin(), part.end());
  edges = joined(std::move(edges));
  std::erase_if(edges, [&](const TrueEdge& e) { return (e.end - e.begin).norm() < options.min_length_m; });
  return edges;
}

}  // namespace cpplus
