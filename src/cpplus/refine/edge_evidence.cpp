#include "cpplus/refine/edge_evidence.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "cpplus/refine/edge_likelihood.h"
#include "cpplus/refine/edgel_index.h"
#include "cpplus/refine/match_weight.h"

namespace cpplus {
namespace {

// Edgels of one chain that lie this near to each other across the edge are one crossing, pixels.
constexpr double kCrossingWidth = 1.0;

// Of the edgels of each crossing the one nearest to the line along the normal, in order along it.
std::vector<Eigen::Vector2f> crossings(const EdgelIndex& index, const std::vector<uint32_t>& edgels,
                                       const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal) {
  struct Crossing {
    double along;
    double beside;
    Eigen::Vector2f pixel;
  };
  std::vector<Crossing> all;
  for (const uint32_t edgel : edgels) {
    const Eigen::Vector2d offset = index.edgel(edgel).pixel.cast<double>() - pixel;
    all.push_back(
        {normal.dot(offset), std::abs(normal.x() * offset.y() - normal.y() * offset.x()), index.edgel(edgel).pixel});
  }
  std::sort(all.begin(), all.end(), [](const Crossing& a, const Crossing& b) { return a.along < b.along; });
  std::vector<Eigen::Vector2f> result;
  for (size_t i = 0; i < all.size();) {
    size_t best = i;
    size_t end = i + 1;
    for (; end < all.size() && all[end].along - all[end - 1].along < kCrossingWidth; ++end) {
      if (all[end].beside < all[best].beside) best = end;
    }
    result.push_back(all[best].pixel);
    i = end;
  }
  return result;
}

}  // namespace

EdgeEvidence::EdgeEvidence(const Camera& camera, const ImagePose& pose, const std::vector<MapEdge>& edges,
                           const std::vector<EdgeSample>& samples, const ImageEdges& image_edges, double radius_px,
                           double max_angle_deg) {
  const EdgelIndex index(image_edges, max_angle_deg);
  const SampleProjector projector(camera, pose);
  std::vector<uint32_t> found;
  for (const EdgeSample& sample : samples) {
    const auto projected = projector.project(sample);
    if (!projected) continue;
    Sample s;
    s.sample = sample;
    s.covariance = edges[sample.edge].covariance.cast<float>();
    s.length_m = static_cast<float>(edges[sample.edge].length());
    s.kind = edges[sample.edge].kind;
    s.group = edges[sample.edge].group;
    s.candidates_begin = static_cast<uint32_t>(candidates_.size());
    index.all_along(projected->pixel, projected->normal, radius_px, &found);
    const std::vector<Eigen::Vector2f> crossed = crossings(index, found, projected->pixel, projected->normal);
    candidates_.insert(candidates_.end(), crossed.begin(), crossed.end());
    s.candidates_end = static_cast<uint32_t>(candidates_.size());
    samples_.push_back(s);
  }
  samples_.shrink_to_fit();
  candidates_.shrink_to_fit();
}

EdgeEvidence::Selection EdgeEvidence::all() const {
  Selection selection(samples_.size());
  std::iota(selection.begin(), selection.end(), 0u);
  return selection;
}

std::vector<EdgeEvidence::Selection> EdgeEvidence::folds(int count) const {
  std::map<uint32_t, size_t> samples_of_group;
  for (const Sample& s : samples_) ++samples_of_group[s.group];
  std::vector<std::pair<size_t, uint32_t>> groups;
  for (const auto& [group, samples] : samples_of_group) groups.emplace_back(samples, group);
  std::stable_sort(groups.begin(), groups.end(), [](const auto& x, const auto& y) { return x.first > y.first; });
  std::map<uint32_t, size_t> fold_of_group;
  for (size_t i = 0; i < groups.size(); ++i) fold_of_group[groups[i].second] = i % static_cast<size_t>(count);
  std::vector<Selection> folds(static_cast<size_t>(count));
  for (uint32_t i = 0; i < samples_.size(); ++i) folds[fold_of_group[samples_[i].group]].push_back(i);
  return folds;
}

std::vector<EdgeMatch> EdgeEvidence::match(const Camera& camera, const ImagePose& pose, double radius_px,
                                           const Noise& noise, const Selection& selection) const {
  std::vector<EdgeMatch> matches;
  const Rigid3 map_from_middle_row = inverse(pose.camera_from_map);
  const SampleProjector projector(camera, pose);
  for (const uint32_t i : selection) {
    const Sample& s = samples_[i];
    if (s.candidates_begin == s.candidates_end) continue;
    const auto projected = projector.project(s.sample);
    if (!projected) continue;
    double nearest_px = radius_px;
    const Eigen::Vector2f* best = nullptr;
    for (uint32_t c = s.candidates_begin; c < s.candidates_end; ++c) {
      const double distance = std::abs(projected->normal.dot(candidates_[c].cast<double>() - projected->pixel));
      if (distance > nearest_px) continue;
      nearest_px = distance;
      best = &candidates_[c];
    }
    if (best == nullptr) continue;
    EdgeMatch m;
    m.x_in_map =
        pose.moves() ? map_from_middle_row * (projected->camera_from_map * s.sample.x_in_map) : s.sample.x_in_map;
    m.row_fraction = row_fraction(best->y(), camera.height());
    m.edge = s.sample.edge;
    m.pixel = best->cast<double>();
    m.normal = projected->normal;
    m.projected = *projected;
    weigh_match(s.covariance.cast<double>(), static_cast<double>(s.length_m), s.sample, noise.image_sigma_px,
                noise.edge_sigma_px, &m);
    matches.push_back(m);
  }
  return matches;
}

double EdgeEvidence::nearest(const Sample& s, const ProjectedSample& projected, double offset_px,
                             double most_px) const {
  double best = most_px;
  for (uint32_t c = s.candidates_begin; c < s.candidates_end; ++c) {
    const double along = projected.normal.dot(candidates_[c].cast<double>() - projected.pixel);
    best = std::min(best, std::abs(along - offset_px));
  }
  return best;
}

std::vector<double> EdgeEvidence::distances(const Camera& camera, const ImagePose& pose, double radius_px,
                                            const Selection& selection) const {
  const SampleProjector projector(camera, pose);
  std::vector<double> result;
  for (const uint32_t i : selection) {
    const auto projected = projector.project(samples_[i].sample);
    if (projected) result.push_back(nearest(samples_[i], *projected, 0.0, radius_px));
  }
  return result;
}

double EdgeEvidence::log_ratio(const Camera& camera, const ImagePose& pose, double kernel_px,
                               const Selection& selection) const {
  const SampleProjector projector(camera, pose);
  std::vector<SampleLikelihood> likelihoods;
  for (const uint32_t i : selection) {
    const Sample& s = samples_[i];
    const auto projected = projector.project(s.sample);
    if (!projected) continue;
    const Eigen::RowVector3d across = projected->normal.transpose() * projected->d_pixel_d_point;
    const double map_variance = (across * s.covariance.cast<double>() * across.transpose()).value();
    const double width = std::sqrt(kernel_px * kernel_px + map_variance);
    likelihoods.push_back(sample_likelihood(s.kind, static_cast<int>(s.sample.edge_samples), width, [&](double offset) {
      return nearest(s, *projected, offset, 3.0 * width);
    }));
  }
  return fitted_log_ratio(likelihoods);
}

}  // namespace cpplus
