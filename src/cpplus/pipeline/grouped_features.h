#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/cloud/point_map.h"
#include "cpplus/geometry/sparse_model.h"
#include "cpplus/io/scratch_file.h"
#include "cpplus/pipeline/feature_store.h"
#include "cpplus/pipeline/map_near_images.h"
#include "cpplus/pipeline/refine_images.h"

namespace cpplus {

/// Which LiDAR intensities MapFeatures hold: none, the map's, or those spread evenly (equalise_intensities()).
enum class KeptIntensities { kNone, kOfMap, kEqualised };

/// The features of a map near the images of a model, in parts that fit into memory: one for each group of images that
/// lie near each other. Each part's planes and edges are found once; with more than one group they then lie in a
/// temporary file, and the points of one group at a time in memory.
class GroupedFeatures {
 public:
  /// Finds the features of all groups, or takes them from the store where there is one (not null; for the time of this
  /// call). Groups have at most max_group_points points
  /// around them where they can be divided (image_groups.h). `map_path`: file that errors name;
  /// `target`: file or folder that the temporary is for (io/scratch_file.h). Throws Error where the map's indices are
  /// damaged, or the temporary cannot be written.
  GroupedFeatures(const std::string& map_path, PointMap points, FeatureStore* store, const SparseModel& model,
                  const RefineImagesOptions& options, KeptIntensities intensities, size_t max_group_points,
                  const std::string& target);

  /// Calls body for each group that has some of the images (indices into the model), with these in their order. Views
  /// of a group's planes stay valid beyond the call, what else is in the features does not. An image alone is in the
  /// group of its own.
  using Body = std::function<void(const MapFeatures& features, const std::vector<size_t>& images)>;
  void for_each_group(const std::vector<size_t>& images, const Body& body);

  size_t num_groups() const { return groups_.size(); }
  /// Of all groups; what several of them hold counts as often.
  size_t num_planes() const;
  size_t num_edges() const { return num_edges_; }
  /// The mean over the groups, metres.
  double noise_m() const;

 private:
  struct Group {
    std::vector<size_t> images;
    MapFeatures features;  // the planes; of the group in memory all
    std::vector<uint64_t> array_sizes;
    uint64_t offset = 0;  // in the temporary, bytes
  };

  void put_away(Group* group);
  void load(size_t g);
  static void unload(Group* group);
  std::vector<Eigen::Vector3d> places_of(const Group& group) const;

  std::string map_path_;
  PointMap points_;
  std::vector<Eigen::Vector3d> places_;
  double reach_m_;
  std::vector<std::unique_ptr<Group>> groups_;
  std::vector<size_t> group_of_;       // by image
  std::unique_ptr<ScratchFile> file_;  // of more than one group
  uint64_t file_end_ = 0;
  std::optional<size_t> loaded_;
  size_t num_edges_ = 0;
};

}  // namespace cpplus
