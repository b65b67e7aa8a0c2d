#include "cpplus/pipeline/image_groups.h"

#include <Eigen/Geometry>
#include <numeric>
#include <utility>

#include "cpplus/cloud/map_part.h"

namespace cpplus {
namespace {

using Indices = std::vector<size_t>;

/// Halves that hold this many times the points of the whole together are not worth it: each part is looked at anew.
constexpr double kMostInBoth = 1.75;

/// What may become a group.
struct Candidate {
  Indices images;
  size_t num_points = 0;  // of the map near them
};

size_t points_near(const VoxelMap& map, const std::vector<Eigen::Vector3d>& places, double reach_m) {
  size_t count = 0;
  for (const uint32_t root : roots_near(map, places, reach_m)) count += map.num_points(0, root);
  return count;
}

std::vector<Eigen::Vector3d> places_of(const std::vector<Eigen::Vector3d>& places, const Indices& images) {
  std::vector<Eigen::Vector3d> some;
  some.reserve(images.size());
  for (const size_t i : images) some.push_back(places[i]);
  return some;
}

/// On both sides of the middle of their longest extent.
std::pair<Indices, Indices> halves(const std::vector<Eigen::Vector3d>& places, const Indices& images) {
  Eigen::AlignedBox3d box;
  for (const size_t i : images) box.extend(places[i]);
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const double middle = box.center()[axis];
  std::pair<Indices, Indices> sides;
  for (const size_t i : images) (places[i][axis] <= middle ? sides.first : sides.second).push_back(i);
  return sides;
}

}  // namespace

std::vector<std::vector<size_t>> group_images(const VoxelMap& map, const std::vector<Eigen::Vector3d>& places,
                                              double reach_m, size_t max_points) {
  if (places.empty()) return {};
  const auto with_count = [&](Indices images) {
    const size_t count = points_near(map, places_of(places, images), reach_m);
    return Candidate{std::move(images), count};
  };
  Indices all(places.size());
  std::iota(all.begin(), all.end(), size_t{0});
  std::vector<Indices> groups;
  std::vector<Candidate> open;
  open.push_back(with_count(std::move(all)));
  while (!open.empty()) {
    Candidate whole = std::move(open.back());
    open.pop_back();
    if (whole.num_points > max_points) {
      auto [images, others] = halves(places, whole.images);
      Candidate first = with_count(std::move(images));
      Candidate second = with_count(std::move(others));
      const auto sum = static_cast<double>(first.num_points + second.num_points);
      if (!second.images.empty() && sum <= kMostInBoth * static_cast<double>(whole.num_points)) {
        open.push_back(std::move(second));
        open.push_back(std::move(first));
        continue;
      }
    }
    groups.push_back(std::move(whole.images));
  }
  return groups;
}

}  // namespace cpplus
