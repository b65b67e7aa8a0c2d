#include "cpplus/pipeline/grouped_features.h"

#include <functional>
#include <numeric>
#include <span>
#include <utility>

#include "cpplus/core/memory.h"
#include "cpplus/core/parallel.h"
#include "cpplus/pipeline/image_groups.h"
#include "cpplus/pipeline/map_near_images.h"

namespace cpplus {
namespace {

/// Calls visit(array) for what a temporary holds of a group.
template <typename Visit>
void for_each_array(MapFeatures* features, const Visit& visit) {
  visit(&features->surface.leaves);
  visit(&features->surface.plane_of);
  visit(&features->surface.centers);
  visit(&features->edges);
  visit(&features->leaf_spacing);
  visit(&features->intensities);
}

std::vector<float> kept_intensities(std::span<const float> of_map, KeptIntensities kept) {
  if (kept == KeptIntensities::kNone) return {};
  std::vector<float> intensities(of_map.begin(), of_map.end());
  return kept == KeptIntensities::kEqualised ? equalise_intensities(intensities) : intensities;
}

PointMap without_attributes(const PointMap& points) {
  PointMap result;
  result.map = points.map;
  return result;
}

}  // namespace

GroupedFeatures::GroupedFeatures(const std::string& map_path, PointMap points, FeatureStore* store,
                                 const SparseModel& model, const RefineImagesOptions& options,
                                 KeptIntensities intensities, size_t max_group_points, const std::string& target)
    : map_path_(map_path),
      points_(std::move(points)),
      places_(camera_centers(model)),
      reach_m_(map_reach_m(options)),
      group_of_(places_.size()) {
  for (std::vector<size_t>& images : group_images(points_.map, places_, reach_m_, max_group_points)) {
    for (const size_t i : images) group_of_[i] = groups_.size();
    groups_.push_back(std::make_unique<Group>());
    groups_.back()->images = std::move(images);
  }
  if (groups_.size() > 1) file_ = std::make_unique<ScratchFile>(target);
  for (const std::unique_ptr<Group>& group : groups_) {
    NearFeatures found = find_features_near(map_path_, points_, places_of(*group), store, options);
    group->features = std::move(found.features);
    group->features.intensities = kept_intensities(found.near.points.intensities, intensities);
    found.near = {};
    num_edges_ += group->features.edges.size();
    if (file_) put_away(group.get());
  }
  // The only group holds what is needed of the map; others are loaded without what only finding features takes.
  points_ = file_ ? without_attributes(points_) : PointMap();
}

void GroupedFeatures::for_each_group(const std::vector<size_t>& images, const Body& body) {
  std::vector<std::vector<size_t>> by_group(groups_.size());
  for (const size_t i : images) by_group[group_of_[i]].push_back(i);
  for (size_t g = 0; g < groups_.size(); ++g) {
    if (by_group[g].empty()) continue;
    load(g);
    body(groups_[g]->features, by_group[g]);
  }
}

size_t GroupedFeatures::num_planes() const {
  return std::accumulate(
      groups_.begin(), groups_.end(), size_t{0},
      [](size_t sum, const std::unique_ptr<Group>& group) { return sum + group->features.planes.planes.size(); });
}

double GroupedFeatures::noise_m() const {
  double sum = 0.0;
  for (const std::unique_ptr<Group>& group : groups_) sum += group->features.planes.noise_m;
  return groups_.empty() ? 0.0 : sum / static_cast<double>(groups_.size());
}

std::vector<Eigen::Vector3d> GroupedFeatures::places_of(const Group& group) const {
  std::vector<Eigen::Vector3d> places;
  places.reserve(group.images.size());
  for (const size_t i : group.images) places.push_back(places_[i]);
  return places;
}

void GroupedFeatures::put_away(Group* group) {
  free_memory(&group->features.planes.plane_of_point);  // only what is found from it is used
  group->offset = file_end_;
  for_each_array(&group->features, [&](auto* array) {
    group->array_sizes.push_back(array->size());
    file_->write(file_end_, array->data(), array->size() * sizeof(*array->data()));
    file_end_ += array->size() * sizeof(*array->data());
  });
  unload(group);
}

void GroupedFeatures::load(size_t g) {
  if (!file_ || loaded_ == g) return;
  if (loaded_) unload(groups_[*loaded_].get());
  loaded_ = g;
  Group& group = *groups_[g];
  std::vector<std::function<void()>> tasks = {
      [&] { group.features.map = map_near_places(map_path_, points_, places_of(group), reach_m_).points.map; }};
  uint64_t offset = group.offset;
  auto size = group.array_sizes.begin();
  for_each_array(&group.features, [&](auto* array) {
    const size_t num_bytes = *size * sizeof(*array->data());
    tasks.emplace_back([this, array, offset, count = *size, num_bytes] {
      array->resize(count);
      file_->read(offset, array->data(), num_bytes);
    });
    offset += num_bytes;
    ++size;
  });
  parallel_for_each(tasks.size(), [&](size_t i) { tasks[i](); });
}

void GroupedFeatures::unload(Group* group) {
  group->features.map = {};
  for_each_array(&group->features, [](auto* array) { free_memory(array); });
  return_freed_memory();
}

}  // namespace cpplus
