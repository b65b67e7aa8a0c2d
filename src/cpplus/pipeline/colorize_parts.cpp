#include "cpplus/pipeline/colorize_parts.h"

#include <fmt/format.h>

#include <memory>
#include <numeric>
#include <set>
#include <utility>

#include "cpplus/cloud/map_part.h"
#include "cpplus/cloud/map_tiles.h"
#include "cpplus/cloud/select_roots.h"
#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/memory.h"
#include "cpplus/core/progress.h"

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
  for (size_t i = 0; i < images.indices.size(); ++i) {
    const PosedImage& image = images.model.images[images.indices[i]];
    std::set<uint32_t> looked_at;
    for (const uint32_t root :
         select_roots(map, images.model.cameras.at(image.camera_id), image.camera_from_map, max_distance_m)) {
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

/// What is known once all samples are taken.
struct SampleCounts {
  std::vector<uint32_t> candidates_of_root;  // for the exposure
  size_t num_colored = 0;                    // points with samples
};

SampleCounts collect_all_samples(const std::string& path, const PointMap& points, const std::vector<MapTile>& parts,
                                 const ColorizeOptions& options, const std::vector<std::vector<size_t>>& by_part,
                                 ImageList* images, SampleFile* file) {
  size_t num_reads = 0;
  for (const std::vector<size_t>& some : by_part) num_reads += some.size();
  Progress progress("colorize", num_reads);
  SampleCounts counts;
  counts.candidates_of_root.resize(points.map.num_nodes(0), 0);
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
      counts.candidates_of_root[root] = static_cast<uint32_t>(count_exposure_candidates(samples, begin, end));
      for (size_t i = begin; i < end; ++i) counts.num_colored += samples.num_views(i) > 0 ? 1 : 0;
      file->add(root, samples, begin, end);
    });
  }
  return_freed_memory();
  return counts;
}

/// Those that collect_exposure_observations() finds in all samples in the order of the map.
ExposureObservations collect_all_observations(const MapColors& colors,
                                              const std::vector<uint32_t>& candidates_of_root) {
  const auto num_candidates = std::accumulate(candidates_of_root.begin(), candidates_of_root.end(), size_t{0});
  const ExposureChoice choice(num_candidates, colors.images.size());
  ExposureObservations observations;
  size_t rank = 0;
  for (const uint32_t root : colors.roots) {
    if (candidates_of_root[root] == 0) continue;
    ColorSamples samples = colors.samples->read(root);
    samples.renumber_images(colors.image_of_sample);
    add_exposure_observations(samples, 0, samples.num_points(), rank, choice, &observations);
    rank += candidates_of_root[root];
  }
  return observations;
}

}  // namespace

PartsColorized colorize_in_parts(const std::string& path, const PointMap& points, std::vector<uint32_t> roots,
                                 const ColorImages& images, const ColorizeOptions& options, size_t max_part_points,
                                 const std::string& target) {
  const VoxelMap& map = points.map;
  PartsColorized colorized;
  MapColors& colors = colorized.colors;
  colors.roots = std::move(roots);
  colors.samples = std::make_unique<SampleFile>(target, map.num_nodes(0), options.max_samples);
  colors.max_deviation = options.max_deviation;
  std::vector<MapTile> parts = divide_roots(map, colors.roots, max_part_points);
  if (parts.empty()) parts.emplace_back();  // nothing is near, but the images are to be read
  if (parts.size() > 1) log_info(fmt::format("colours in {} parts of the map", parts.size()));
  ImageList list(images);
  const SampleCounts counts = collect_all_samples(path, points, parts, options,
                                                  images_by_part(map, parts, images, options.sampling.max_distance_m),
                                                  &list, colors.samples.get());
  colorized.used = list.used();
  ColorizeResult& result = colorized.result;
  result.num_colored = counts.num_colored;
  result.images = colors.images = list.used_images();
  colors.image_of_sample = list.index_among_used();
  colors.correction =
      equalize_exposure(collect_all_observations(colors, counts.candidates_of_root), options.exposure, &result);
  return colorized;
}

}  // namespace cpplus
