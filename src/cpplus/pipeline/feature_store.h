#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/cloud/map_tiles.h"
#include "cpplus/cloud/point_map.h"
#include "cpplus/cloud/tile_features.h"
#include "cpplus/core/options.h"
#include "cpplus/pipeline/map_near_images.h"
#include "cpplus/pipeline/refine_images.h"

namespace cpplus {

struct FeatureStoreOptions {
  /// Planes and edges of a map with more points are found in tiles of at most so many; with what is around a tile some
  /// 90 bytes of memory a point, for a tile a thread but four at most. [1, 2^31)
  int max_points = 2'000'000;
  /// How far around a tile is looked at as well, metres. [1, inf)
  double halo_m = 4.0;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("max_points", max_points, "Maps with more points are worked on in tiles of at most so many points.");
    visitor("halo_m", halo_m, "How far around a tile is looked at as well, metres.");
  }
};

/// The planes and edges of a voxel map file, found once: each tile of the map (cloud/map_tiles.h) in a file of its own
/// in the folder MAP.vox.features (docs/index.md). Files of another map or of other options are left alone, damaged
/// ones are replaced. Where the folder cannot be written, features are found anew each time; a warning says so once.
class FeatureStore {
 public:
  /// Of the map in the file `map_path`, whose points are `points`. Throws Error where the file's header is damaged.
  FeatureStore(const std::string& map_path, PointMap points, const RefineImagesOptions& stages,
               const FeatureStoreOptions& options);

  /// The features in some roots (ascending), of which `near` is the map, see join_tiles(). Tiles that have not been
  /// looked at are now. Throws Error where the map's indices are damaged.
  MapFeatures find(const std::vector<uint32_t>& roots, const VoxelMap& near);

  /// Looks at the tiles of these roots of which there is no file, and keeps nothing of them in memory: before `near` is
  /// made for find(), so that the two are not in memory at a time.
  void look_at(const std::vector<uint32_t>& roots);

  /// Looks at all tiles that have not been looked at yet.
  void find_all();

  /// Tiles that were looked at so far, and how often features were read that were there before.
  size_t num_found() const { return num_found_; }
  size_t num_read() const { return num_read_; }

 private:
  std::vector<size_t> tiles_of(const std::vector<uint32_t>& roots) const;
  std::string path_of(size_t tile) const;
  std::string key_of(size_t tile) const;
  std::optional<TileFeatures> read(size_t tile, std::string* problem) const;
  void keep(size_t tile, const TileFeatures& features);
  void look_at(const std::vector<size_t>& tiles, const std::function<bool(size_t k, TileFeatures features)>& visit);
  std::vector<TileFeatures> load(const std::vector<size_t>& tiles);

  std::string folder_;
  PointMap points_;
  RefineImagesOptions stages_;
  FeatureStoreOptions options_;
  std::string key_;
  std::vector<MapTile> tiles_;
  std::vector<bool> is_found_;     // by tile: looked at by this store
  std::optional<double> noise_m_;  // of more than one tile, once it was needed
  size_t num_found_ = 0;
  size_t num_read_ = 0;
  bool is_writable_ = true;
};

/// The store of a map where its features are kept, which takes a voxel map file; else nothing.
std::optional<FeatureStore> open_feature_store(const std::string& map_path, const PointMap& points, bool keep_features,
                                               const RefineImagesOptions& stages, const FeatureStoreOptions& options);

/// The part of a map within reach of some places, and its features.
struct NearFeatures {
  NearMap near;
  MapFeatures features;
};

/// From the store where there is one (not null), else found in the part alone. Throws what map_near_places() does.
NearFeatures find_features_near(const std::string& map_path, const PointMap& points,
                                const std::vector<Eigen::Vector3d>& places, FeatureStore* store,
                                const RefineImagesOptions& stages);

/// The folder for the features of a voxel map file.
std::string features_folder(const std::string& map_path);

/// Removes what a FeatureStore has kept of a voxel map file.
void remove_features(const std::string& map_path);

}  // namespace cpplus
