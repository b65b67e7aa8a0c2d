#include "cpplus/pipeline/feature_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/option_list.h"
#include "cpplus/core/parallel.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/tile_features_file.h"
#include "cpplus/io/voxel_map_file.h"
#include "cpplus/pipeline/join_tiles.h"
#include "cpplus/pipeline/tile_features.h"

namespace cpplus {
namespace {

constexpr const char* kEnding = ".tile";
/// Tiles in memory at a time, whatever the number of threads.
constexpr size_t kTilesAtATime = 4;

template <typename Options>
std::string options_text(const std::string& name, Options options) {
  std::string text;
  for (const OptionField& field : list_options(options, name)) {
    text += fmt::format(" {}={}", field.path, option_text(field));
  }
  return text;
}

/// FNV-1a, to tell the files of different keys apart by name; the key itself is in the file.
uint64_t hash_of(const std::string& text) {
  uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<uint8_t>(c)) * 0x100000001b3u;
  return hash;
}

}  // namespace

void FeatureStoreOptions::validate() const {
  check_option(max_points >= 1, "max_points", "[1, 2^31)", max_points);
  check_option(halo_m >= 1.0, "halo_m", "[1, inf)", halo_m);
}

std::optional<FeatureStore> open_feature_store(const std::string& map_path, const PointMap& points, bool keep_features,
                                               const RefineImagesOptions& stages, const FeatureStoreOptions& options) {
  if (!keep_features || !is_voxel_map_file(map_path)) return std::nullopt;
  return FeatureStore(map_path, points, stages, options);
}

NearFeatures find_features_near(const std::string& map_path, const PointMap& points,
                                const std::vector<Eigen::Vector3d>& places, FeatureStore* store,
                                const RefineImagesOptions& stages) {
  NearFeatures result;
  const std::vector<uint32_t> roots = roots_near_places(points.map, places, map_reach_m(stages));
  if (store != nullptr) store->look_at(roots);
  result.near = part_near(map_path, points, roots);
  if (store != nullptr) {
    result.features = store->find(roots, result.near.points.map);
  } else {
    Progress progress("map", kMapSteps);
    result.features = extract_map_features(result.near.points, stages, &progress);
  }
  return result;
}

std::string features_folder(const std::string& map_path) { return map_path + ".features"; }

void remove_features(const std::string& map_path) {
  namespace fs = std::filesystem;
  const fs::path folder = features_folder(map_path);
  std::error_code ignored;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == kEnding) files.push_back(entry.path());
  }
  for (const fs::path& file : files) fs::remove(file, ignored);
  if (fs::is_directory(folder, ignored)) fs::remove(folder, ignored);  // where nothing else is in it
}

FeatureStore::FeatureStore(const std::string& map_path, PointMap points, const RefineImagesOptions& stages,
                           const FeatureStoreOptions& options)
    : folder_(features_folder(map_path)),
      points_(std::move(points)),
      stages_(stages),
      options_(options),
      key_(fmt::format("map={}{}{}{}", voxel_map_fingerprint(map_path), options_text("tiles", options),
                       options_text("planes", stages.planes), options_text("map_edges", stages.map_edges))),
      tiles_(divide_map(points_.map, static_cast<size_t>(options.max_points))),
      is_found_(tiles_.size(), false) {
  remove_leftovers(folder_);
}

MapFeatures FeatureStore::find(const std::vector<uint32_t>& roots, const VoxelMap& near) {
  const std::vector<size_t> indices = tiles_of(roots);
  std::vector<const MapTile*> tiles;
  for (const size_t t : indices) tiles.push_back(&tiles_[t]);
  return join_tiles(points_.map, near, roots, tiles, load(indices), stages_);
}

void FeatureStore::look_at(const std::vector<uint32_t>& roots) {
  if (!is_writable_) return;  // what is not kept is looked at by find()
  std::vector<size_t> missing;
  for (const size_t t : tiles_of(roots)) {
    if (!std::filesystem::exists(path_of(t))) missing.push_back(t);
  }
  look_at(missing, [this](size_t, const TileFeatures&) { return is_writable_; });
}

void FeatureStore::find_all() {
  for (size_t t = 0; t < tiles_.size(); t += kTilesAtATime) {
    std::vector<size_t> some;
    for (size_t k = t; k < std::min(t + kTilesAtATime, tiles_.size()); ++k) some.push_back(k);
    load(some);
  }
}

std::vector<size_t> FeatureStore::tiles_of(const std::vector<uint32_t>& roots) const {
  std::vector<size_t> tiles;
  for (size_t t = 0; t < tiles_.size(); ++t) {
    const bool is_one = std::any_of(tiles_[t].roots.begin(), tiles_[t].roots.end(), [&](uint32_t root) {
      return std::binary_search(roots.begin(), roots.end(), root);
    });
    if (is_one) tiles.push_back(t);
  }
  return tiles;
}

std::string FeatureStore::key_of(size_t tile) const { return fmt::format("{} tile={}/{}", key_, tile, tiles_.size()); }

std::string FeatureStore::path_of(size_t tile) const {
  return (std::filesystem::path(folder_) / fmt::format("{:06}-{:016x}{}", tile, hash_of(key_), kEnding)).string();
}

/// Nothing where there is no such file; where it is damaged, `problem` says so.
std::optional<TileFeatures> FeatureStore::read(size_t tile, std::string* problem) const {
  try {
    return read_tile_features(path_of(tile), key_of(tile));
  } catch (const Error& error) {
    *problem = error.what();
    return std::nullopt;
  }
}

void FeatureStore::keep(size_t tile, const TileFeatures& features) {
  if (!is_writable_) return;
  try {
    write_tile_features(path_of(tile), key_of(tile), features);
  } catch (const Error& error) {
    is_writable_ = false;
    log_warning(fmt::format("{}; planes and edges of the map are not kept", error.what()));
  }
}

/// Visits the features of tiles[k] in the order of k, until a visit returns false.
void FeatureStore::look_at(const std::vector<size_t>& tiles,
                           const std::function<bool(size_t k, TileFeatures features)>& visit) {
  if (!tiles.empty() && tiles_.size() > 1 && !noise_m_) noise_m_ = sampled_noise_m(points_.map, stages_.planes);
  Progress progress("map", kMapSteps * tiles.size());
  for (size_t begin = 0; begin < tiles.size(); begin += kTilesAtATime) {
    const size_t end = std::min(begin + kTilesAtATime, tiles.size());
    std::vector<TileFeatures> found(end - begin);
    parallel_for_each(end - begin, [&](size_t i) {
      const MapTile& tile = tiles_[tiles[begin + i]];
      found[i] = find_tile_features(points_, tile, options_.halo_m, noise_m_, stages_, &progress);
    });
    for (size_t i = 0; i < found.size(); ++i) {
      keep(tiles[begin + i], found[i]);
      is_found_[tiles[begin + i]] = true;
      ++num_found_;
      if (!visit(begin + i, std::move(found[i]))) return;
    }
  }
}

std::vector<TileFeatures> FeatureStore::load(const std::vector<size_t>& tiles) {
  std::vector<TileFeatures> features(tiles.size());
  std::vector<char> is_there(tiles.size(), 0);
  std::vector<std::string> problems(tiles.size());
  parallel_for_each(tiles.size(), [&](size_t k) {
    std::optional<TileFeatures> found = read(tiles[k], &problems[k]);
    if (!found) return;
    features[k] = std::move(*found);
    is_there[k] = 1;
  });
  std::vector<size_t> places, missing;
  for (size_t k = 0; k < tiles.size(); ++k) {
    if (!problems[k].empty()) log_warning(fmt::format("{}; it is made anew", problems[k]));
    if (is_there[k] != 0) {
      num_read_ += is_found_[tiles[k]] ? 0 : 1;
      continue;
    }
    places.push_back(k);
    missing.push_back(tiles[k]);
  }
  look_at(missing, [&](size_t k, TileFeatures found) {
    features[places[k]] = std::move(found);
    return true;
  });
  return features;
}

}  // namespace cpplus
