#include "cpplus/pipeline/colorize_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "cpplus/cloud/map_part.h"
#include "cpplus/cloud/map_tiles.h"
#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/memory.h"
#include "cpplus/core/progress.h"
#include "cpplus/pipeline/sample_file.h"

namespace cpplus {
namespace {

/// The images of a list, by its indices, that each part is offered to. One that looks at no part is offered to the
/// first, so that it is read all the same.
std::vector<std::vector<size_t>> images_by_part(const VoxelMap& map, const std::vector<MapTile>& parts,
                                                const ColorImages& images, double max_distance_m) {
  std::vector<uint32_t> part_of_root(map.num_nodes(0), 0);
  for (uint32_t part = 0; part < parts.size(); ++part) {
    for (const uint32_t root : parts[part].roots) part_of_root[root] = part;
  }
  std::vector<std::vector<size_t>> by_part(parts.size());
  for (size_t i = 0; i < images.indices.size() && !parts.empty(); ++i) {
    const PosedImage& image = images.model.images[images.indices[i]];
    const Eigen::Vector3d axis_in_map = image.camera_from_map.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    std::set<uint32_t> looked_at;
    for (const uint32_t root :
         map.roots_in_frustum(camera_center(image.camera_from_map), axis_in_map,
                              images.model.cameras.at(image.camera_id).max_view_angle(), max_distance_m)) {
      looked_at.insert(part_of_root[root]);
    }
    if (looked_at.empty()) looked_at.insert(0);
    for (const uint32_t part : looked_at) by_part[part].push_back(i);
  }
  return by_part;
}

/// What is found out about the images while the parts take samples from them.
class ImageList {
 public:
  explicit ImageList(const ColorImages& images) : images_(images), states_(images.indices.size()) {}

  /// The view of an image of the list; nothing where it cannot be used, which is found out once.
  std::optional<ColorView> read(size_t i) {
    State& state = states_[i];
    if (state.unusable) return std::nullopt;
    std::optional<ColorView> view = images_.read(images_.indices[i]);
    state.unusable = !view;
    if (!view) return view;
    view->index = color_view_index(i, view->name);
    state.image = {view->name, view->image_id, view->camera_id, {}};
    state.used = true;
    return view;
  }

  std::vector<size_t> used() const {
    std::vector<size_t> used;
    for (size_t i = 0; i < states_.size(); ++i) {
      if (states_[i].used) used.push_back(images_.indices[i]);
    }
    return used;
  }
  std::vector<ColorizedImage> used_images() const {
    std::vector<ColorizedImage> used;
    for (const State& state : states_) {
      if (state.used) used.push_back(state.image);
    }
    return used;
  }
  /// Index among the used ones, of all.
  std::vector<uint16_t> index_among_used() const {
    std::vector<uint16_t> index;
    uint16_t next = 0;
    for (const State& state : states_) index.push_back(state.used ? next++ : uint16_t{0});
    return index;
  }

 private:
  struct State {
    bool used = false;
    bool unusable = false;
    ColorizedImage image;
  };
  const ColorImages& images_;
  std::vector<State> states_;
};

VoxelMap map_of(const std::string& path, const PointMap& points, const MapTile& part) {
  PointMap some;
  some.map = points.map;
  try {
    return part_of_map(some, part.roots).map;  // attributes give no colour
  } catch (const Error& error) {
    throw Error(fmt::format("{}: damaged: {}", path, error.what()));
  }
}

/// Calls visit(root, begin, end) for each root of a part with the range of its points among the part's.
template <typename Visit>
void for_each_root(const VoxelMap& map, const MapTile& part, const Visit& visit) {
  size_t begin = 0;
  for (const uint32_t root : part.roots) {
    const size_t end = begin + map.num_points(0, root);
    visit(root, begin, end);
    begin = end;
  }
}

/// Samples of all parts, and how many candidates for the exposure each root of the map has.
std::vector<uint32_t> collect_all_samples(const std::string& path, const PointMap& points,
                                          const std::vector<MapTile>& parts, const ColorizeOptions& options,
                                          const std::vector<std::vector<size_t>>& by_part, ImageList* images,
                                          SampleFile* file) {
  size_t num_reads = 0;
  for (const std::vector<size_t>& some : by_part) num_reads += some.size();
  Progress progress("colorize", num_reads);
  std::vector<uint32_t> num_candidates(points.map.num_nodes(0), 0);
  for (size_t p = 0; p < parts.size(); ++p) {
    size_t next = 0;
    const auto next_view = [&]() -> std::optional<ColorView> {
      while (next < by_part[p].size()) {
        std::optional<ColorView> view = images->read(by_part[p][next++]);
        progress.advance();
        if (view) return view;
      }
      return std::nullopt;
    };
    const ColorSamples samples = collect_color_samples(map_of(path, points, parts[p]), next_view, options);
    for_each_root(points.map, parts[p], [&](uint32_t root, size_t begin, size_t end) {
      num_candidates[root] = static_cast<uint32_t>(count_exposure_candidates(samples, begin, end));
    });
    file->add(samples);
    return_freed_memory();
  }
  return num_candidates;
}

/// Those that collect_exposure_observations() finds in all samples in the order of the map.
ExposureObservations collect_all_observations(const VoxelMap& map, const std::vector<MapTile>& parts,
                                              const std::vector<uint32_t>& num_candidates, size_t num_images,
                                              const std::function<ColorSamples(size_t)>& samples_of) {
  std::vector<size_t> candidates_before = {0};
  for (const uint32_t count : num_candidates) candidates_before.push_back(candidates_before.back() + count);
  const ExposureChoice choice(candidates_before.back(), num_images);
  std::map<uint32_t, ExposureObservations> of_root;
  for (size_t p = 0; p < parts.size(); ++p) {
    const ColorSamples samples = samples_of(p);
    for_each_root(map, parts[p], [&](uint32_t root, size_t begin, size_t end) {
      if (num_candidates[root] == 0) return;
      ExposureObservations some;
      add_exposure_observations(samples, begin, end, candidates_before[root], choice, &some);
      if (some.num_points() > 0) of_root.emplace(root, std::move(some));
    });
  }
  ExposureObservations all;
  for (const auto& [root, some] : of_root) all.append(some);
  return all;
}

}  // namespace

PartsColorized colorize_in_parts(const std::string& path, const PointMap& points, const ColorImages& images,
                                 const ColorizeOptions& options, size_t max_part_points, const std::string& target,
                                 MapColors* colors) {
  const VoxelMap& map = points.map;
  const std::vector<MapTile> parts = divide_roots(map, colors->roots(), max_part_points);
  if (parts.size() > 1) log_info(fmt::format("colours in {} parts of the map", parts.size()));
  SampleFile file(target, options.max_samples);
  ImageList list(images);
  const std::vector<uint32_t> num_candidates = collect_all_samples(
      path, points, parts, options, images_by_part(map, parts, images, options.sampling.max_distance_m), &list, &file);

  PartsColorized colorized{{}, list.used()};
  ColorizeResult& result = colorized.result;
  result.images = list.used_images();
  const std::vector<uint16_t> index_among_used = list.index_among_used();
  const auto samples_of = [&](size_t part) {
    ColorSamples samples = file.read(part);
    samples.renumber_images(index_among_used);
    return samples;
  };
  const ExposureCorrection correction =
      equalize_exposure(collect_all_observations(map, parts, num_candidates, result.images.size(), samples_of),
                        options.exposure, &result);
  for (size_t p = 0; p < parts.size(); ++p) {
    const std::vector<ColoredPoint> colored =
        color_points(samples_of(p), correction, result.images, options.max_deviation);
    result.num_colored += static_cast<size_t>(
        std::count_if(colored.begin(), colored.end(), [](const ColoredPoint& point) { return point.num_views > 0; }));
    for_each_root(map, parts[p], [&](uint32_t root, size_t begin, size_t end) {
      colors->write(root, std::span(colored).subspan(begin, end - begin));
    });
  }
  return_freed_memory();
  return colorized;
}

}  // namespace cpplus
